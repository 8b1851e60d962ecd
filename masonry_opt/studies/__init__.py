"""Studies, which use the package as a user would: the paper's examples, comparisons, many scenes."""
