"""Settings of all tests."""

from hypothesis import settings

settings.register_profile("asv", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("asv")
