"""What follows the onset of collapse: finite motion of hinging mechanisms, and what codes check with it."""
