"""Learned policies: their files, and the networks that run them on NumPy."""
