"""Sentences, summaries and warnings, made from codes and numbers when somebody asks."""
