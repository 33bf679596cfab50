"""Parts of the main window: menus, docks, bars, dialogs."""
