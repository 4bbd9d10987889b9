"""The pre-commit hook and the GitHub Action, as their users' machines run them: shell commands in an empty folder."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from command_line import robimp
from ruamel.yaml import YAML

from robimp.synthesis.errors import ExitCode

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
HOOKS, ACTION = (YAML(typ="safe").load(ROOT / name) for name in (".pre-commit-hooks.yaml", "action.yml"))
BASH = shutil.which("bash")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    for name in ("paper", "stiff"):
        robimp("synth", EXAMPLES / f"haninger2016-{name}.yaml", "-o", folder / name)
    return folder


@pytest.fixture
def repository(results: Path, tmp_path: Path) -> Path:
    """Somebody's repository: nothing but a specification and its certificate, with a blank in its name."""
    (tmp_path / "my joints" / "elbow").mkdir(parents=True)
    shutil.copy(results / "paper" / "certificate.json", tmp_path / "my joints" / "elbow")
    shutil.copy(EXAMPLES / "haninger2016-paper.yaml", tmp_path / "elbow.yaml")
    return tmp_path


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The command as pip would install it, from the entry point that is declared."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]["robimp"]
    module, function = declared.split(":")
    script = tmp_path_factory.mktemp("bin") / "robimp"
    script.write_text(f"#!{sys.executable}\nfrom {module} import {function}\n{function}()\n")
    script.chmod(0o755)
    return {**os.environ, "PATH": f"{script.parent}{os.pathsep}{os.environ['PATH']}"}


def shell(
    command: list[str], repository: Path, environment: dict[str, str], **inputs: str
) -> subprocess.CompletedProcess[str]:
    merged = environment | inputs
    return subprocess.run(command, cwd=repository, env=merged, capture_output=True, text=True, timeout=60)


# pre-commit


def hook(repository: Path, environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """What pre-commit does: the entry, the user's arguments, and every file of the repository that the hook wants."""
    (entry,) = HOOKS
    files = [str(file.relative_to(repository)) for file in sorted(repository.rglob("*.*")) if file.is_file()]
    wanted = [file for file in files if re.search(entry["files"], file)]
    return shell([*shlex.split(entry["entry"]), *arguments, *wanted], repository, environment)


def test_the_hook_is_one_pre_commit_can_install() -> None:
    (entry,) = HOOKS
    assert entry["id"] == "robimp-check" and entry["language"] == "python" and entry["types"] == ["json"]
    wanted = ["certificate.json", "a b/certificate.json", "out/elbow-certificate.json", "elbow.certificate.json"]
    assert all(re.search(entry["files"], file) for file in wanted)
    assert not any(
        re.search(entry["files"], file) for file in ("simulation.json", "certificate.jsonc", "nocertificate.json")
    )


def test_the_hook_is_green_and_red(repository: Path, results: Path, environment: dict[str, str]) -> None:
    green = hook(repository, environment, "--spec", "elbow.yaml")
    assert (green.returncode, green.stderr) == (0, "") and green.stdout.startswith("PROVEN  my joints/elbow/cert")
    shutil.copy(results / "stiff" / "certificate.json", repository)
    red = hook(repository, environment)
    assert red.returncode == ExitCode.REFUTED and "certificate.json: eq12 structured" in red.stderr
    assert "my joints" in red.stdout, "every certificate is judged"


def test_the_documented_hook_is_red_when_only_the_specification_is_edited(
    repository: Path, environment: dict[str, str]
) -> None:
    """pre-commit passes edited files that match `files`, and skips a hook that gets none, unless told otherwise."""
    lines = (ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8").splitlines()
    (asked,) = YAML(typ="safe").load("\n".join(line[4:] for line in lines if line.startswith("#   ")))
    assert asked.pop("id") == HOOKS[0]["id"] and asked["always_run"] and not asked["pass_filenames"]
    (repository / "my joints" / "elbow" / "certificate.json").rename(repository / "gripper.certificate.json")
    spec = (repository / "elbow.yaml").read_text(encoding="utf-8")
    for inertia, code in (("0.03 ", ExitCode.PROVEN), ("0.031 ", ExitCode.MISMATCH)):
        (repository / "gripper.yaml").write_text(
            spec.replace("inertia: 0.03 ", f"inertia: {inertia}"), encoding="utf-8"
        )
        done = shell([*shlex.split(HOOKS[0]["entry"]), *asked["args"]], repository, environment)
        assert done.returncode == code, done.stderr


def test_the_hook_is_red_for_another_specification(repository: Path, environment: dict[str, str]) -> None:
    spec = repository / "elbow.yaml"
    spec.write_text(spec.read_text(encoding="utf-8").replace("inertia: 0.03 ", "inertia: 0.031 "), encoding="utf-8")
    red = hook(repository, environment, "--spec", "elbow.yaml")
    assert red.returncode == ExitCode.MISMATCH and "plant.inertia 0.03 → 0.031" in red.stderr


# The action


def step(name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(step for step in ACTION["runs"]["steps"] if step.get("name") == name)
    return found


def action(repository: Path, environment: dict[str, str], **inputs: str) -> subprocess.CompletedProcess[str]:
    """The step that checks, as the runner starts it, with the inputs where the step's environment wants them."""
    given = {name: value.get("default", "") for name, value in ACTION["inputs"].items()} | inputs
    assert given.keys() == ACTION["inputs"].keys()
    variables = {
        variable: given[re.fullmatch(r"\$\{\{ inputs\.([\w-]+) \}\}", source)[1]]  # type: ignore[index]
        for variable, source in step("Check certificates")["env"].items()
    }
    script = repository.parent / "step.sh"
    script.write_text(step("Check certificates")["run"], encoding="utf-8")
    command = [BASH or "bash", "--noprofile", "--norc", "-e", "-o", "pipefail", str(script)]
    return shell(command, repository, environment, **variables)


def test_the_action_installs_without_evaluating_an_input() -> None:
    assert ACTION["runs"]["using"] == "composite"
    assert [s["uses"].split("@")[0] for s in ACTION["runs"]["steps"] if "uses" in s] == ["actions/setup-python"]
    runs = [s for s in ACTION["runs"]["steps"] if "run" in s]
    assert len(runs) == 2 and all(s["shell"] == "bash" and "${{" not in s["run"] for s in runs)
    assert {name for name, value in ACTION["inputs"].items() if value.get("required")} == {"certificates"}


@pytest.mark.skipif(BASH is None, reason="the action's steps are bash")
@pytest.mark.parametrize(
    ("release", "source", "wanted"),
    [("", "/a b/robimp", "/a b/robimp"), ("0.1.0", "/a b/robimp", "robimp==0.1.0")],
    ids=["path", "version"],
)
def test_the_action_installs_a_release_or_a_path(
    release: str, source: str, wanted: str, tmp_path: Path, environment: dict[str, str]
) -> None:
    pip = tmp_path / "bin" / "python"
    pip.parent.mkdir()
    pip.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    pip.chmod(0o755)
    path = {"PATH": f"{pip.parent}{os.pathsep}{environment['PATH']}"}
    command = [BASH or "bash", "-e", "-c", step("Install robimp")["run"]]
    done = shell(command, tmp_path, environment | path, RELEASE=release, SOURCE=source)
    assert done.stdout.splitlines()[:3] == ["-m", "pip", "install"] and done.stdout.splitlines()[-1] == wanted


@pytest.mark.skipif(BASH is None, reason="the action's steps are bash")
def test_the_action_is_green_and_red(repository: Path, results: Path, environment: dict[str, str]) -> None:
    inputs = {"certificates": "**/certificate.json", "spec": "elbow.yaml", "junit": "reports/junit.xml"}
    green = action(repository, environment, **inputs)
    assert (green.returncode, green.stderr) == (0, "") and green.stdout.startswith("PROVEN  my joints/elbow/cert")
    assert ET.parse(repository / "reports" / "junit.xml").getroot().attrib["failures"] == "0"
    shutil.copy(results / "stiff" / "certificate.json", repository / "stiff.json")
    inputs["certificates"] += "\nstiff.json\n"
    red = action(repository, environment, **inputs)
    assert red.returncode == ExitCode.MISMATCH and "stiff.json: of another specification" in red.stderr
    assert ET.parse(repository / "reports" / "junit.xml").getroot().attrib["failures"] == "3"
    red = action(repository, environment, certificates=inputs["certificates"], controller="stiff.json")
    assert red.returncode == ExitCode.REFUTED and red.stderr.count("\n") == 1, "both have the same Q"


@pytest.mark.skipif(BASH is None, reason="the action's steps are bash")
@pytest.mark.parametrize(
    "certificates", ["", "\n", "none/*.json", "--help", "$(touch evil)", "`touch evil`; touch evil"]
)
def test_the_action_is_red_for_nothing_and_runs_no_file_name(
    certificates: str, repository: Path, environment: dict[str, str]
) -> None:
    red = action(repository, environment, certificates=certificates)
    assert red.returncode == ExitCode.INPUT and red.stdout == "" and red.stderr.count("\n") == 1
    assert not (repository / "evil").exists()
