"""Fields over the image: edge map, electric field, potential."""
