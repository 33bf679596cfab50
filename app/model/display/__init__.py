"""What is drawn, as numbers: colors, lines, scales and plots, without Qt."""
