"""The command `movingout cluster`."""
