"""Methods of scikit-image and OpenCV that divide the image into regions, step by step where they have steps."""
