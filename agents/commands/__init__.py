"""`movingout agents`, `demos` and `train`."""
