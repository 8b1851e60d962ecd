"""Where the methods fail: a registry of failures, and maps of the loop's parameters."""
