"""The network: which object a prompt means, learned from images that people have outlined."""
