"""The page in a real browser: no error, every plot drawn, no text over another; skipped where there is no Chromium."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from report_pages import EQ23, LOWERED, PAPER, Page, html

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")

WATCH = """<script>
window.errors = [];
window.onerror = (text) => window.errors.push(String(text));
console.error = (...said) => window.errors.push(said.join(" "));
addEventListener("securitypolicyviolation", (e) => window.errors.push(`${e.violatedDirective} ${e.blockedURI}`));
</script>"""

LOOK = """<script>(() => {
  const BLOCKS = "h1,h2,h3,h4,p,li,dt,dd,td,th,figcaption,.plot,.formula,summary";
  const box = (element) => element.getBoundingClientRect();
  const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
  function overlapping(elements) {
    const found = [], boxes = elements.map((e) => [e, box(e)]).filter(([, b]) => b.width && b.height);
    boxes.forEach(([e, a], k) => boxes.slice(k + 1).forEach(([f, b]) => {
      if (!e.contains(f) && !f.contains(e) && meet(a, b)) found.push(`${e.textContent} | ${f.textContent}`);
    }));
    return found;
  }
  function look() {
    if (!document.documentElement.dataset.complete) return setTimeout(look, 50);
    const plots = [...document.querySelectorAll(".plot")].filter((p) => p.dataset.drawn);
    const written = (p) => [...p.querySelectorAll("svg text")].filter((t) => t.textContent.trim());
    const report = {
      errors: window.errors,
      plots: plots.length,
      curves: plots.map((p) => p.querySelectorAll(".scatterlayer path.js-line, .scatterlayer path.point").length),
      texts: plots.flatMap((p) => overlapping(written(p))),
      ticks: plots.flatMap((p) => ["x", "y"].filter((a) => p.layout[`${a}axis`].type === "log").map((a) => ({
        range: p.layout[`${a}axis`].range, said: [...p.querySelectorAll(`.${a}tick text`)].map((t) => t.textContent),
      }))),
      blocks: overlapping([...document.querySelectorAll(BLOCKS)]),
      wide: document.documentElement.scrollWidth - innerWidth,
      page: getComputedStyle(document.body).backgroundColor,
      ink: plots[0].querySelector(".xtick text").style.fill,
      toggled: (document.getElementById("theme").click(), getComputedStyle(document.body).backgroundColor),
      fetched: performance.getEntriesByType("resource").map((entry) => entry.name),
    };
    const place = document.body.appendChild(document.createElement("pre"));
    place.id = "look";
    place.textContent = JSON.stringify(report);
  }
  look();
})();</script>"""


@dataclass(frozen=True)
class Seen:
    """What a page looked like in the browser."""

    report: dict[str, Any]
    console: str

    @property
    def complaints(self) -> list[str]:
        """Everything that should not be there."""
        found = [*self.report["errors"], *self.report["texts"], *self.report["blocks"], *self.report["fetched"]]
        found += [f"plot {k} is empty" for k, count in enumerate(self.report["curves"]) if not count]
        found += [f"{self.report['wide']} px too wide"] if self.report["wide"] > 0 else []
        found += [f"ticks {axis}" for axis in self.report["ticks"] if not legible(axis["said"], axis["range"])]
        return found + [line for line in self.console.splitlines() if "CONSOLE" in line]


def legible(ticks: list[str], ends: list[float]) -> bool:
    """Whether every tick of an axis over 10^ends is the value it stands at, and at least two have one."""
    said = [text.replace("\u200b", "").replace("−", "-") for text in ticks if text]
    values = [math.log10(float(t)) if t[:2] != "10" or t in ("10", "100") else float(t[2:] or 1) for t in said]
    return len(values) > 1 and values == sorted(values) and ends[0] - 0.01 <= values[0] and values[-1] <= ends[1] + 0.01


def test_a_tick_that_is_only_a_digit_is_seen() -> None:
    assert legible(["0.5", "1", "2"], [-0.4, 0.4]) and legible(["10\u200b−1", "1", "10", "10\u200b2"], [-1.1, 2.5])
    assert not legible(["5", "10", "2"], [0.6, 1.4]) and not legible(["5", "1"], [-0.4, 0.1])


def seen(page: str, folder: Path, *flags: str) -> Seen:
    """Open a page, wait until its plots are drawn, and look."""
    file = folder / "page.html"
    watched = page.replace("<style>", f"{WATCH}<style>", 1).replace("</body>", f"{LOOK}</body>")
    file.write_text(watched, encoding="utf-8")
    command = [str(BROWSER), "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}"]
    command += ["--virtual-time-budget=20000", "--enable-logging=stderr", "--dump-dom", *flags, file.as_uri()]
    done = subprocess.run(command, capture_output=True, timeout=120)
    text = done.stdout.decode("utf-8", "replace")
    look = re.search(r'<pre id="look">(.*?)</pre>', text, re.DOTALL)
    assert look is not None, done.stderr.decode("utf-8", "replace")[-2000:]
    unescaped = look[1].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    return Seen(json.loads(unescaped), done.stderr.decode("utf-8", "replace"))


DARK = "--blink-settings=preferredColorScheme=0"
LIGHT_PAGE, DARK_PAGE = "rgb(255, 255, 255)", "rgb(18, 22, 29)"


@pytest.mark.parametrize("width", [1280, 500], ids=["laptop", "narrow"])
def test_a_page_opens_without_a_complaint(width: int, tmp_path: Path) -> None:
    page = html(PAPER)
    look = seen(page, tmp_path, f"--window-size={width},900")
    assert look.complaints == []
    assert look.report["plots"] == len(Page(page).figures) >= 15
    assert (look.report["page"], look.report["toggled"]) == (LIGHT_PAGE, DARK_PAGE)


def test_dark_is_dark_also_in_the_plots(tmp_path: Path) -> None:
    look = seen(html(LOWERED), tmp_path, DARK)
    assert look.complaints == []
    assert (look.report["page"], look.report["toggled"]) == (DARK_PAGE, LIGHT_PAGE)
    red = int(re.search(r"\d+", look.report["ink"])[0])  # type: ignore[index]
    assert red > 180


def test_a_comparison_draws_what_is_unfolded(tmp_path: Path) -> None:
    page = html(PAPER, EQ23)
    look = seen(page.replace("<details>", "<details open>", 1), tmp_path)
    assert look.complaints == []
    assert look.report["plots"] == 2 + len(Page(html(PAPER)).figures)


def test_what_is_wrong_with_a_page_is_seen(tmp_path: Path) -> None:
    broken = html(PAPER).replace("<h3>Controller", '<p style="position: absolute">over</p><h3>Controller', 1)
    broken = broken.replace(
        "</main>", '<img src="https://example.invalid/a.png"><div style="width: 3000px">x</div></main>'
    )
    broken = broken.replace('"traces":[', '"traces":[],"was":[', 1)
    note = '{"text":"%s","x":0.5,"y":0.5,"xref":"paper","yref":"paper","showarrow":false}'
    broken = broken.replace("return span > 2.2 ?", 'return true ? { dtick: "D2" } : span > 2.2 ?', 1)
    broken = broken.replace('"annotations":[]', f'"annotations":[{note % "one"},{note % "two"}]', 1)
    complaints = seen(broken, tmp_path).complaints
    for expected in ("over | ", "one | two", "too wide", "img-src", "is empty", "ticks {"):
        assert any(expected in said for said in complaints), (expected, complaints)
