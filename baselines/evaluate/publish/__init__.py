"""Published results on the pages of this repository."""
