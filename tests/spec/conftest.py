from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

SPECS = Path(__file__).parents[1] / "data" / "specs"


@pytest.fixture(scope="session")
def good() -> str:
    """A specification without fault, in the fewest lines."""
    return (SPECS / "good.yaml").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def edit(good: str) -> Callable[..., str]:
    """The good specification with some of its text replaced; each piece must stand in it exactly once."""

    def replaced(*pairs: tuple[str, str]) -> str:
        text = good
        for old, new in pairs:
            assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in good.yaml"
            text = text.replace(old, new)
        return text

    return replaced
