"""Every command and code block of the README and the documentation does what the page says."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import update
from pages import ROOT, Block, Page, WrongBlockError, blocks, matches

PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "examples" / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]


@pytest.mark.parametrize("name", NAMES)
def test_a_page_does_what_it_says(name: str, tmp_path: Path) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    if "$ cc " in text and shutil.which("cc") is None:
        pytest.skip("no C compiler: the page compiles what it exports")
    Page(tmp_path).follow(text, name)


def test_the_pages_have_blocks_and_few_are_not_run() -> None:
    found = [block for name in NAMES for block in blocks((ROOT / name).read_text(encoding="utf-8"), name)]
    assert len(found) > 40
    skipped = [block for block in found if block.reason]
    assert len(skipped) < 10
    assert all(len(block.reason or "") > 10 for block in skipped), "a reason is a sentence"


SPEC = "robimp: 1\nname: a"
WRONG = {
    "a command that fails": ("```console\n$ false\n```", "ends with 1"),
    "a robimp command that fails": ("```console\n$ robimp check absent.json\n```", "ends with 2"),
    "a failure that is not the one shown": ("```console\n$ robimp check absent.json\n$ echo $?\n4\n```", "prints\n2"),
    "other output": ("```console\n$ echo one\ntwo\n```", "prints\none"),
    "missing output": ("```console\n$ echo one\none\ntwo\n```", "prints\none"),
    "more output": ("```console\n$ printf 'one\\ntwo\\n'\none\n```", "prints\none"),
    "python that fails": ("```python\nx = 1\n```\n\n```python\nassert x == 2\n```", "AssertionError"),
    "python that prints something else": ("```python\nprint(1)\n```\n\n```text\n2\n```", "prints\n1"),
    "a misspelt section": ("```yaml\nplannt: {inertia: 1}\n```", "plannt"),
    "a number out of range": ("```yaml\nplant: {inertia: -1, damping: 0, stiffness: 0}\n```", "inertia"),
    "a specification that is none": (f'```yaml title="a.yaml"\n{SPEC}\n```', "motion"),
    "an edit of what is not there": ('```console\n$ echo a >a.txt\n```\n```diff title="a.txt"\n-b\n+c\n```', "0 times"),
    "an unknown language": ("```fortran\nEND\n```", "nothing runs a block of fortran"),
    "no language": ("```\nrobimp\n```", "nothing runs a block of no language"),
    "an indented block": ("See\n\n    robimp check\n", "indentation"),
    "output without its code": ("```text\n1\n```", "nothing runs a block of text"),
    "no reason": ("<!-- not run: -->\n```sh\nfalse\n```", "nothing runs a block of sh"),
    "a comment that is not right above": ("<!-- not run: it is slow -->\n\nSee\n\n```sh\nfalse\n```", "of sh"),
}


@pytest.mark.parametrize(("text", "said"), WRONG.values(), ids=WRONG)
def test_a_wrong_block_is_caught(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(WrongBlockError) as caught:
        Page(tmp_path).follow(text, "page.md")
    assert said in str(caught.value)
    assert str(caught.value).startswith("page.md:")


RIGHT = {
    "a command": "```console\n$ echo one\none\n```",
    "a failure that is shown": "```console\n$ robimp check absent.json\n…\n$ echo $?\n2\n```",
    "an elided line": "```console\n$ printf 'a\\nb\\nc\\n'\na\n…\nc\n```",
    "an elided part": "```console\n$ echo in 4.2 s\nin … s\n```",
    "python with output": "```python\nprint(1)\n```\n\n```text\n1\n```",
    "a section": "```yaml\nplant: {inertia: 0.03, damping: 0.2, stiffness: 0}\n```",
    "an edit": '```console\n$ echo a >a.txt\n```\n```diff title="a.txt"\n-a\n+c\n```\n```console\n$ cat a.txt\nc\n```',
    "what is not run": "<!-- not run: it would install packages -->\n```sh\nfalse\n```",
}


@pytest.mark.parametrize("text", RIGHT.values(), ids=RIGHT)
def test_a_right_block_passes(text: str, tmp_path: Path) -> None:
    Page(tmp_path).follow(text, "page.md")


def test_an_ellipsis_stands_for_no_more_than_it_says() -> None:
    assert matches("in … s", "in 4 s\n") and not matches("in … s", "in 4 min\n")
    assert not matches("in … s", "in 4\nx s\n")
    assert matches("a\n…\nc", "a\nc") and not matches("a\n…\nc", "a\nb")


def test_blocks_are_found_where_they_are() -> None:
    found = blocks('a\n\n```yaml title="x.yaml"\na: 1\n```\n\n- b\n\n  ```console\n  $ ls\n  ```\n', "p.md")
    assert [(b.place, b.language, b.title) for b in found] == [
        ("p.md:3", "yaml", "x.yaml"),
        ("p.md:9", "console", None),
    ]
    assert isinstance(found[0], Block) and found[1].text == "$ ls\n"


def test_a_page_is_brought_up_to_date(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    listing = "```console\n$ printf 'a 1\\nb 2\\nc 3\\n'\n{}\n```\n"
    wrong = ["a …\nx\nc 3", "a 1\nx\n…", "a …\n…", "a 1"]
    right = ["a …\nb 2\nc 3", "a 1\nb 2\n…", "a …\n…", "a 1\nb 2\nc 3"]
    code = "```python\nprint(2)\n```\n\n```text\n{}\n```\n"
    page.write_text("\n".join([*map(listing.format, wrong), code.format(1)]), encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["update.py", str(page)])
    update.main()
    assert page.read_text(encoding="utf-8") == "\n".join([*map(listing.format, right), code.format(2)])
