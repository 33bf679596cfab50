"""What has been found: contours, skeleton, and a truth to compare with."""
