"""Code shared by the formats: provenance, printable text, and atomic writing of files."""
