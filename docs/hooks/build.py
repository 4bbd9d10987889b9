"""What the build needs besides MkDocs: formulas as MathML, so no script is fetched, and the packages by their names.

`<!-- public names -->` becomes the reference of every name that `robimp.synthesis` exports.
"""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.plugins import event_priority

from robimp import synthesis

FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[\(\[](.*?)\\[\)\]]</\1>', re.DOTALL)
ROOT = Path(__file__).parents[2]


def mathml(html: str) -> str:
    """A page with every LaTeX formula that pymdownx.arithmatex marked as MathML, which browsers draw themselves."""

    def drawn(match: re.Match[str]) -> str:
        display = "block" if match[1] == "div" else "inline"
        return str(convert(unescape(match[2]).strip(), display=display))

    return FORMULA.sub(drawn, html)


@event_priority(100)  # before mkdocstrings looks which of its paths exist
def on_config(config: Any) -> Any:
    """Put `models` and `synthesis` under build/names/robimp, where the API reference is read without importing them."""
    names = ROOT / "build" / "names" / "robimp"
    names.mkdir(parents=True, exist_ok=True)
    for folder in ("models", "synthesis"):
        if not (names / folder).exists():
            (names / folder).symlink_to(ROOT / folder, target_is_directory=True)
    return config


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Called by MkDocs with every page's source."""
    names = sorted(synthesis.__all__, key=lambda name: (name[0].isupper(), name))
    return markdown.replace("<!-- public names -->", "\n\n".join(f"::: robimp.synthesis.{name}" for name in names))


def on_page_content(html: str, **_: Any) -> str:
    """Called by MkDocs with every page."""
    return mathml(html)
