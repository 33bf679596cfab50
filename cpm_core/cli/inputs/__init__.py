"""What commands take: images and the parts of them that are read, sessions, starts, and ground truths."""
