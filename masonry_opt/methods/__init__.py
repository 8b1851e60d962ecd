"""One folder or file a method: a task in, a solution out."""
