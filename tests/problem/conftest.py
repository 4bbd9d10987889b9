from __future__ import annotations

import numpy as np
import pytest

FILTERED = "{type: dob, order: 4, filters: {force: 100, position: none, derivative: 400}}"


@pytest.fixture(params=range(4))
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    return np.random.default_rng(request.param)


@pytest.fixture
def omega(rng: np.random.Generator) -> np.ndarray:
    """Random frequencies over everything the joint does."""
    return np.sort(10 ** rng.uniform(-2, 4, 60))


@pytest.fixture
def many() -> list[tuple[np.random.Generator, np.ndarray]]:
    """Eight generators with frequencies each, for what holds in all of them and differs in at least one."""
    generators = [np.random.default_rng(seed) for seed in range(8)]
    return [(rng, np.sort(10 ** rng.uniform(-2, 4, 60))) for rng in generators]


@pytest.fixture(params=["{type: dob, order: 4}", FILTERED], ids=["unfiltered", "filtered"])
def controller(request: pytest.FixtureRequest) -> str:
    """Controller sections, with and without sensor filters."""
    return str(request.param)
