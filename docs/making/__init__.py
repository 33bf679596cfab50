"""Pages and figures of the documentation that are made from the program when it is built, and stored nowhere."""
