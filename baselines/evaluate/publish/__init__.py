"""Writes published results onto the pages of this repository, and adds policies to them."""
