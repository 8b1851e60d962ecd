"""Colours of every chart."""

from __future__ import annotations

#: Okabe & Ito's (2008), told apart by colour-blind readers; black last.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
