"""Each example's `compare()` gives what it says, is small, and runs as a script."""

from __future__ import annotations

import importlib
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
CLOSE, EQUAL = 0.005, 1e-12  # relative
AGREE = {  # by how much ours may differ from what is expected, row by row
    "papers_joint": (CLOSE, CLOSE, CLOSE),
    "papers_tuning": (EQUAL, CLOSE, EQUAL, CLOSE),
    "stiffness_range": (EQUAL, EQUAL, 0.01, None),
    "dynamic_error_feedback": (EQUAL, 1e-4, 1e-4),
    "sampled_500hz": (EQUAL, 1e-4, 1e-2),  # margins on cells are within 1 % of the truth
    "published_actuators": (EQUAL, 1e-3, EQUAL, 1e-3),
    "certificate_in_ci": (EQUAL, EQUAL, EQUAL, EQUAL),
    "measured_to_c": (0.01, EQUAL, EQUAL, 0.01, 0),
}


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], object]:
    """An example as a module."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    return importlib.import_module


Example = Callable[[str], object]


@pytest.mark.parametrize("name", AGREE)
def test_an_example_agrees_with_what_is_published_or_expected(name: str, example: Example) -> None:
    if name == "measured_to_c" and shutil.which("cc") is None:
        pytest.skip("no C compiler: the example compiles what it exports")
    rows = example(name).compare()  # type: ignore[attr-defined]
    assert len(rows) == len(AGREE[name])
    for (what, ours, expected), tolerance in zip(rows, AGREE[name], strict=True):
        if tolerance is None:  # more than is asked for
            assert ours >= expected > 0, what
        else:
            assert ours == pytest.approx(expected, rel=tolerance, abs=1e-9), what


def test_the_tolerances_tell_a_wrong_figure_from_a_right_one() -> None:
    assert pytest.approx(40.3, rel=CLOSE) == 40.29 and pytest.approx(40.3, rel=CLOSE) != 39.9
    assert pytest.approx(0, rel=EQUAL) != 4


def test_there_are_eight_and_the_index_names_each() -> None:
    index = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    scripts = {path.stem: path.read_text(encoding="utf-8") for path in EXAMPLES.glob("*.py")}
    compared = {name for name, text in scripts.items() if "def compare()" in text}
    assert compared == set(AGREE) and len(compared) >= 8
    for name in compared:
        assert f"`{name}.py`" in index
        assert len(scripts[name].splitlines()) < 100
    for path in EXAMPLES.glob("*.yaml"):
        assert f"`{path.name}`" in index


def test_a_recorded_certificate_that_does_not_hold_stops_its_example(
    tmp_path: Path, example: Example, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = example("compared")
    shutil.copy(EXAMPLES / "haninger2016.yaml", tmp_path)
    (tmp_path / "certificates").mkdir()
    monkeypatch.setattr(compared, "FOLDER", tmp_path)
    path = tmp_path / "certificates" / "haninger2016.json"
    text = (EXAMPLES / "certificates" / "haninger2016.json").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    assert compared.recorded("haninger2016")["robimp_certificate"] == 1  # type: ignore[attr-defined]
    path.write_text(text.replace('"proven": "', '"proven": "9'), encoding="utf-8")
    with pytest.raises(ValueError, match="digest"):
        compared.recorded("haninger2016")  # type: ignore[attr-defined]
    path.write_text(text, encoding="utf-8")
    spec = tmp_path / "haninger2016.yaml"
    spec.write_text(spec.read_text(encoding="utf-8").replace("inertia: 0.03 ", "inertia: 0.031 "), encoding="utf-8")
    with pytest.raises(ValueError, match="another specification"):
        compared.recorded("haninger2016")  # type: ignore[attr-defined]


@pytest.mark.parametrize("path", sorted((EXAMPLES / "certificates").glob("*.json")), ids=lambda path: path.stem)
def test_a_recorded_certificate_is_named_as_its_specification(path: Path) -> None:
    assert json.loads(path.read_text(encoding="utf-8"))["spec"]["name"] == path.stem
    assert (EXAMPLES / f"{path.stem}.yaml").exists()


def test_an_example_runs_as_a_script_from_any_folder(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "certificate_in_ci.py")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 5 and "expected" in done.stdout.splitlines()[0]
