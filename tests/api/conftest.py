"""A certified joint, and a folder in which the examples of the docstrings run."""

from __future__ import annotations

from pathlib import Path

import pytest

from robimp.synthesis import Result, synthesize

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="session")
def result() -> Result:
    return synthesize(EXAMPLES / "haninger2016-paper.yaml")


@pytest.fixture
def folder(result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory: the examples, and a certificate of one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(EXAMPLES, target_is_directory=True)
    (tmp_path / "certificate.json").write_bytes(result.certificate_bytes())
    return tmp_path
