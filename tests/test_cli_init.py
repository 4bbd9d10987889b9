"""`robimp init`: a specification that is accepted as it stands, and never one that replaces the user's own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import robimp

from robimp.synthesis.spec import load_spec, spec_warnings
from robimp.synthesis.spec.template import template


@pytest.mark.parametrize("kind", ["series-elastic", "ideal"])
def test_the_template_is_accepted_without_a_warning(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    done = robimp("init", "arm", "--actuator", kind, "-o", path)
    assert (done.code, done.err) == (0, "")
    assert done.out == f"wrote {path}; next: robimp synth {path}\n"
    spec = load_spec(path)
    assert (spec.name, spec.actuator.type) == ("arm", kind)
    assert spec_warnings(spec) == ()


def test_every_key_is_explained() -> None:
    keys = [line for line in template("arm", "series-elastic").splitlines() if line.startswith("  ")]
    silent = [line for line in keys if "#" not in line]
    assert len(silent) < len(keys) / 2


def test_a_file_that_exists_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    path.write_text("mine")
    done = robimp("init", "arm", "-o", path)
    assert done.code == 2
    assert "--force" in done.err
    assert path.read_text() == "mine"
    assert robimp("init", "arm", "-o", path, "--force").code == 0
    assert "name: arm" in path.read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a b"], "name"),
        (["../arm"], "name"),
        (["arm", "--actuator", "hydraulic"], "hydraulic"),
        (["arm", "-o", "/dev/null"], "no ordinary file"),
    ],
)
def test_what_cannot_be_written_is_refused(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = robimp("init", *arguments)
    assert done.code == 2
    assert said in done.err
    assert len(done.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_json_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    assert json.loads(robimp("init", "arm", "-o", path, "--json").out) == {"file": str(path)}


def test_the_version_is_told() -> None:
    done = robimp("--version")
    assert done.code == 0
    assert done.out.startswith("robimp 0.")
