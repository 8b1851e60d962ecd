"""Many scenes: one scene as numbers of it change, by processes or on a cluster."""
