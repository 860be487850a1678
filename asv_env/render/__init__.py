"""Pictures and films of the worlds."""
