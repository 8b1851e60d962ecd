"""Incremental analysis by load steps: a second program for the incremental load factor.

The program raises the live load by steps and lets the blocks move, damped, until they are in equilibrium
again; :mod:`masonry_opt.methods.push` follows the equilibrium path by continuation. Of the package it takes
matrices, joint laws and certificates, and nothing of the push.
"""
