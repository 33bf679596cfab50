"""What the main window is assembled from: menus, docks, bars, dialogs."""
