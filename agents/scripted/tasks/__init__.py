"""What a scripted player can be busy with."""
