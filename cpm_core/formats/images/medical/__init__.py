"""Files of medicine: volumes with a place in space."""
