"""Entry point of ``python -m masonry_opt``, which is the command ``masonry-opt``."""

from masonry_opt.cli import main

main()
