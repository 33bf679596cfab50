"""Methods of scikit-image that divide the image into regions, step by step where they have steps."""
