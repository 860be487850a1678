"""Training of policies that all boats share: ``python -m train``."""
