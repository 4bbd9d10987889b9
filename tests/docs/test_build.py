"""`make docs`: strict, without network, formulas drawn by the browser itself, every public name in the reference."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import ROOT

from robimp import synthesis

pytest.importorskip("mkdocs", reason="the extra `docs` is not installed")
FETCHED = re.compile(r"""<(?:script|link|img|iframe)[^>]*?(?:src|href)=["']?((?:https?:)?//[^"' >]+)""")


def build(configuration: Path, site: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mkdocs", "build", "-f", str(configuration), "-d", str(site)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "http_proxy": "localhost:9", "https_proxy": "localhost:9"}
    return subprocess.run(
        command, cwd=configuration.parent, env=environment, capture_output=True, text=True, timeout=120
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Every page by its name, as it is built."""
    folder = tmp_path_factory.mktemp("site")
    shutil.rmtree(ROOT / "build" / "names", ignore_errors=True)  # as in a fresh clone
    done = build(ROOT / "mkdocs.yml", folder)
    assert done.returncode == 0, done.stderr
    return {str(path.relative_to(folder)): path.read_text(encoding="utf-8") for path in folder.rglob("*.html")}


def test_every_page_is_built(site: dict[str, str]) -> None:
    sources = {path.relative_to(ROOT / "docs").with_suffix(".html") for path in (ROOT / "docs").rglob("*.md")}
    assert {str(path) for path in sources} <= site.keys() and len(sources) >= 12


def test_nothing_is_fetched(site: dict[str, str]) -> None:
    assert FETCHED.findall('<script src="https://example.org/x.js"></script><link rel=a href=//example.org/f.css>')
    assert {name: found for name, page in site.items() if (found := FETCHED.findall(page))} == {}


def test_formulas_are_drawn_by_the_browser(site: dict[str, str]) -> None:
    theory = [page for name, page in site.items() if name.startswith("theory")]
    assert sum(page.count("<math") for page in theory) > 100
    left = re.compile(r'class="arithmatex"|\\(?:frac|text|omega|tilde|operatorname)\b')
    assert left.search(r"\frac{1}{2}")
    assert [
        name for name, page in site.items() if left.search(re.sub(r"<code.*?</code>", "", page, flags=re.DOTALL))
    ] == []


def test_every_public_name_is_in_the_reference(site: dict[str, str]) -> None:
    page = site["api.html"]
    assert [name for name in synthesis.__all__ if f'id="robimp.synthesis.{name}"' not in page] == []
    assert 'id="robimp.synthesis.absent"' not in page


def test_a_link_to_nowhere_stops_the_build(tmp_path: Path) -> None:
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    (tmp_path / "docs").mkdir()
    text = (tmp_path / "mkdocs.yml").read_text(encoding="utf-8")
    head, rest = text.split("nav:\n")
    (tmp_path / "mkdocs.yml").write_text(
        f"{head}nav: [index.md]\n" + rest[rest.index("exclude_docs") :], encoding="utf-8"
    )
    for folder in ("hooks", "style"):
        shutil.copytree(ROOT / "docs" / folder, tmp_path / "docs" / folder)
    for package in ("models", "synthesis"):
        (tmp_path / package).mkdir()
    page = tmp_path / "docs" / "index.md"
    page.write_text("# A page\n\nSee [itself](index.md).\n", encoding="utf-8")
    assert build(tmp_path / "mkdocs.yml", tmp_path / "site").returncode == 0
    page.write_text("# A page\n\nSee [nothing](nowhere.md).\n", encoding="utf-8")
    done = build(tmp_path / "mkdocs.yml", tmp_path / "site")
    assert done.returncode != 0 and "nowhere.md" in done.stderr
