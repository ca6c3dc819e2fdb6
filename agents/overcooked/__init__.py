"""BASS in Overcooked-AI's "Cramped Room" (paper, "Can BASS be used as a standalone Method beyond Moving Out?")."""
