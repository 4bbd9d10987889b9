from __future__ import annotations

import pytest
from random_joints import Draw, Joint

FILTERS = ["none", "shared", "separate", "unfiltered"]  # "unfiltered": the position channel, specified `none`


@pytest.fixture(params=range(2))
def draw(request: pytest.FixtureRequest) -> Draw:
    return Draw(request.param)


@pytest.fixture(params=FILTERS)
def joint(request: pytest.FixtureRequest) -> Joint:
    """A random joint with each arrangement of sensor filters."""
    return Draw(10 + FILTERS.index(request.param)).joint(request.param)
