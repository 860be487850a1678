"""Settings of all tests, and what several of their modules share."""

import pytest
from hypothesis import settings

settings.register_profile("asv", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("asv")


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The report on invented episodes; see ``invented.report``."""
    import invented  # needs the extra [eval]

    return invented.report(tmp_path_factory.mktemp("report"))
