"""One time step of a run: motion, deletion and insertion; `plane` for images, `space` for volumes."""
