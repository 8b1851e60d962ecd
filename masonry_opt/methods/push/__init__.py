"""The path of a scene whose contacts give a little, from rest to the ray at its end."""
