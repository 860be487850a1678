"""Training of one policy for all teams, hulls and waters, a network of sets."""
