"""Recordings in 3D: an inspector in the browser (viser), and one offline page of an episode to hand on."""
