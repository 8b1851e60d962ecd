"""What programs decide beside a load factor: does a scene stand, what would hold it, is there no collapse."""
