"""The claims of the publication, tested on drawn images next to classical methods."""
