"""How differently episodes were played: the paper's four diversity measures, and pictures of where the robots were."""
