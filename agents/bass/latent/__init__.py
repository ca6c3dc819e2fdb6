"""BASS that simulates in a latent space of whatever an agent sees: pictures, or another game."""
