"""The page itself: a template, a style sheet, a script and the plotting library in one self-contained file.

`plotly-cartesian.min.js` is plotly.js-cartesian-dist-min 4.1.1, unchanged (MIT, `plotly-LICENSE`).
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

if TYPE_CHECKING:
    from .chapter import Chapter
    from .figure import Figure

Together = tuple[list["Figure"], tuple[list[str], list[list[str]]]]  # plots, and a table's headings and rows


def page(chapters: Sequence[Chapter], names: Sequence[str], together: Together | None) -> str:
    """The HTML. Every text is escaped by the template; data of plots is JSON in which `<` cannot end a script."""
    environment = Environment(
        loader=FunctionLoader(asset), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment.get_template("page.html").render(
        chapters=list(zip(names, chapters, strict=True)),
        together=together,
        style=Markup(asset("page.css")),
        script=Markup(asset("page.js")),
        plotly=Markup(asset("plotly-cartesian.min.js")),
        drawn=_drawn(chapters, together),
    )


def asset(name: str) -> str:
    """A file beside this module."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _drawn(chapters: Sequence[Chapter], together: Together | None) -> list[dict[str, Any]]:
    """Every figure's data, in the order of the page: what the script draws into the k-th place for a plot."""
    figures = [] if together is None else [*together[0]]
    figures += [figure for chapter in chapters for section in chapter.sections for figure in section.figures]
    return [figure.data for figure in figures]
