"""What the formats share: provenance, printable text, and the writing of files."""
