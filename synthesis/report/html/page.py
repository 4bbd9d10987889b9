"""The page itself: a template, a style sheet, a script and the plotting library in one self-contained file.

`plotly-cartesian.min.js` is plotly.js-cartesian-dist-min 4.1.1, unchanged (MIT, `plotly-LICENSE`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from .words import symbols

if TYPE_CHECKING:
    from .chapter import Chapter
    from .figure import Figure

Together = tuple[list["Figure"], tuple[list[str], list[list[str]]]]  # plots, and a table's headings and rows


def page(chapters: Sequence[Chapter], names: Sequence[str], together: Together | None) -> str:
    """The HTML about certificates; together: what compares them."""
    figures = [] if together is None else [*together[0]]
    figures += [figure for chapter in chapters for section in chapter.sections for figure in section.figures]
    return rendered(
        "page.html",
        figures,
        title=", ".join(names),
        heading=names[0] if together is None else f"{len(names)} certificates",
        subtitle="Robust impedance control with proofs: what is proven, how tight it is, and what it looks like.",
        chapters=list(zip(names, chapters, strict=True)),
        together=together,
    )


def rendered(template: str, drawn: Iterable[Figure], **context: Any) -> str:
    """The HTML of a template and the figures drawn on it, in its order: the script draws the k-th into the k-th place.

    Every text is escaped by the template, or by its filter `symbols`; data of plots is JSON in which `<` cannot
    end a script.
    """
    environment = Environment(
        loader=FunctionLoader(asset), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["symbols"] = symbols
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment.get_template(template).render(
        style=Markup(asset("page.css")),
        script=Markup(asset("page.js")),
        plotly=Markup(asset("plotly-cartesian.min.js")),
        drawn=[figure.data for figure in drawn],
        **context,
    )


def asset(name: str) -> str:
    """A file beside this module."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
