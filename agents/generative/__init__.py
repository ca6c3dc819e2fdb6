"""Partners out of a generative model: one latent vector says who plays, drawn at random or searched for."""
