"""The reference joint of the search's tests, with lines of its specification replaced."""

from __future__ import annotations

from pathlib import Path

from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import parse_spec

GOOD = (Path(__file__).parents[1] / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")


def setting(*pairs: tuple[str, str]) -> Setting:
    text = GOOD
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return Setting.of(parse_spec(text))
