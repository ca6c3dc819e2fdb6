"""Episodes to learn from: made, labelled, and cut into training windows."""
