"""What `make test` hands down to the processes that it starts."""

import pytest


@pytest.fixture(autouse=True)
def outside_of_make(monkeypatch):
    """A make within a make tells its folders among what it prints."""
    for name in ("MAKELEVEL", "MAKEFLAGS", "MFLAGS"):
        monkeypatch.delenv(name, raising=False)
