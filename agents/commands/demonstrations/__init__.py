"""The actions of `movingout demos`."""
