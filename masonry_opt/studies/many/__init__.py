"""Many scenes: a scene whose numbers change, solved by processes or on a cluster."""
