"""What the table of contours and the table of objects have in common: columns, rows that stay in place, the view."""
