"""How the shipped agents are trained. `recipe` says what from what and in which order; `make agents` carries it out."""
