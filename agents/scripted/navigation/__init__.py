"""Path planning for robots and for what they carry."""
