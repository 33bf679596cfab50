"""Colors, lines, scale bars and plots as numbers, without Qt."""
