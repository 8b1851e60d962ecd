"""Report: answers about a scene on one page."""
