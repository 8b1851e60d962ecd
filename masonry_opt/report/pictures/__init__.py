"""Pictures of scenes and results, one file a kind."""
