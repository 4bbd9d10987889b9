"""What `robimp.synthesis` hands on: these names and no others, each documented, each loaded when first used."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import robimp.synthesis

# Frozen: a name may join; one that leaves or is renamed breaks somebody's program.
NAMES = {
    "functions": "bound check export identify init judge load map_plane parse report schema simulate synthesize",
    "types": "ExitCode Exported Map Polynomials Result Spec Verdict",
    "errors": "InfeasibleError InputError MismatchError RefutedError RobimpError UndecidedError",
}
COMMANDS = {"synth": "synthesize", "map": "map_plane"}  # Python's name, where the command's is another
PUBLIC = sorted(name for names in NAMES.values() for name in names.split())


def test_the_names_are_these() -> None:
    assert sorted(robimp.synthesis.__all__) == PUBLIC


@pytest.mark.parametrize("name", PUBLIC)
def test_every_name_is_there_and_documented(name: str) -> None:
    found = getattr(robimp.synthesis, name)
    documented = found.__call__ if inspect.ismodule(found) else found
    assert callable(found) and len((documented.__doc__ or "").splitlines()[0]) > 10


def test_every_command_has_its_function() -> None:
    from typer.main import get_command

    from robimp.synthesis.cli.entry import app

    commands = set(get_command(app).commands)  # type: ignore[attr-defined]
    assert {COMMANDS.get(name, name) for name in commands} <= set(NAMES["functions"].split())
    assert len(commands) >= 9


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="synthesise"):
        _ = robimp.synthesis.synthesise  # type: ignore[attr-defined]


@pytest.mark.parametrize("folder", ["report", "identify", "check", "export"])
@pytest.mark.parametrize("first", ["name", "folder"])
def test_a_function_with_the_name_of_a_folder_is_the_function_whatever_is_loaded_first(folder: str, first: str) -> None:
    name, package = f"from robimp.synthesis import {folder}", f"import robimp.synthesis.{folder}"
    lines = [name, package] if first == "name" else [package, name]
    script = "\n".join([*lines, f"from robimp.synthesis import {folder} as again", f"assert callable({folder})"])
    script += "\nassert callable(again)"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


def test_the_types_are_for_a_type_checker_too() -> None:
    root = Path(robimp.synthesis.__file__).parent
    text = (root / "__init__.py").read_text(encoding="utf-8")
    checked = text.split("if TYPE_CHECKING:")[1].split("__all__")[0] + text.split("if TYPE_CHECKING:")[0]
    assert [name for name in PUBLIC if name not in checked] == []
