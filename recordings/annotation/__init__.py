"""What people say about failure cases that rules found: each is confirmed or rejected while it is watched."""
