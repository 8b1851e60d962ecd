"""Sentences, summaries and warnings, written from reason codes and numbers."""
