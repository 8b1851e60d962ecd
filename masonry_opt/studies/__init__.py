"""What uses the package as a user would: the paper's examples, comparisons of solvers, many scenes."""
