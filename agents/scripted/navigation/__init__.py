"""Ways over the floor, for robots and for what they carry."""
