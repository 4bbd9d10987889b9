"""The layering, the weight of what is imported, and the tidiness of the tree; each rule is shown an offender first."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {"models": ROOT / "models", "synthesis": ROOT / "synthesis"}
LAYERS = ["errors", "interruption", "storage", "notebook", "models", "spec", "problem", "solve", "certificate", "check"]
LAYERS += ["simulation", "written", "report", "identify", "agreement", "recheck", "design", "pipeline", "sweep"]
LAYERS += ["challenge", "replay"]
LAYERS += ["controller_file", "judgement", "export", "api", "cli"]
HEAVY = ("cvxpy", "casadi", "control", "matplotlib", "numpy", "flint")
MOST_LINES = 300
PRINTERS = {"synthesis/cli/common.py", "synthesis/check/__main__.py"}
MACHINE_PATH = re.compile(r"(?<![\w.)}])/(?:home|root|work|tmp|Users|mnt|opt|srv)/\w")
TEXT = {".py", ".md", ".toml", ".txt", ".yaml", ".yml", ".sh", ".tsv", ".json", ".svg", ""}
NOT_OURS = {".git", ".venv", "build", "dist", "out", "__pycache__"}


def modules() -> dict[str, Path]:
    """Dotted name (`synthesis.solve.nlp`) to file, for everything that is installed."""
    found = {}
    for name, folder in PACKAGES.items():
        for file in sorted(folder.rglob("*.py")):
            parts = [name, *file.relative_to(folder).with_suffix("").parts]
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


MODULES = modules()


def runs(tree: ast.AST) -> Iterator[ast.AST]:
    """Every node that is executed: what stands under `if TYPE_CHECKING` is not."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            for other in node.orelse:
                yield other
                yield from runs(other)
            continue
        yield node
        yield from runs(node)


def imports(source: str, module: str, *, package: bool = False) -> set[str]:
    """What a module's source imports at run time: our own modules as `models.…`/`synthesis.…`, others by full name."""
    base = module.split(".") if package else module.split(".")[:-1]
    found = set()
    for node in runs(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            stem = node.module.split(".") if node.module else []
            if node.level:
                stem = base[: len(base) - node.level + 1] + stem
            for alias in node.names:  # `from .solve import bound` may name a module
                deeper = ".".join([*stem, alias.name])
                found.add(deeper if deeper in MODULES else ".".join(stem))
    return {name.removeprefix("robimp.") for name in found}


def layer(module: str) -> str | None:
    """The station a module belongs to: None for other people's packages."""
    first, _, rest = module.partition(".")
    return first if first == "models" else rest.split(".")[0] if first == "synthesis" else None


def misplaced(source: str, module: str, *, package: bool = False) -> list[str]:
    """Imports that go against the order of the stations, or that a station forbids itself."""
    here, found = layer(module), []
    for name in sorted(imports(source, module, package=package)):
        there = layer(name)
        if here == "check":
            if there not in (None, "check") or (there is None and name.split(".")[0] not in sys.stdlib_module_names):
                found.append(f"{module} imports {name}: check is the standard library and itself")
        elif there is None or there == here or (module, name) == ("synthesis", "synthesis.check"):
            continue  # the package hands `check` on at once, because the folder has the same name
        elif there not in LAYERS or here not in LAYERS or LAYERS.index(there) > LAYERS.index(here):
            found.append(f"{module} imports {name}: a later station")
        elif here == "certificate" and there == "solve":
            found.append(f"{module} imports {name}: a proof that knows the search")
        elif here == "simulation" and there in ("models", "problem", "certificate"):
            found.append(f"{module} imports {name}: a simulation that shares formulas with the proof")
    return found


def source_of(module: str) -> tuple[str, bool]:
    return MODULES[module].read_text(encoding="utf-8"), MODULES[module].name == "__init__.py"


OFFENDERS = [
    ("synthesis.problem.grid", "from ..solve.nlp import Program", "later station"),
    ("synthesis.problem.grid", "def f():\n    from ..solve import nlp", "later station"),
    ("synthesis.problem.constraints.eq9", "from ...certificate.claims import Claim", "later station"),
    ("synthesis.solve.search", "from ..certificate.claims import certify", "later station"),
    ("models.actuator", "from robimp.synthesis.spec import load_spec", "later station"),
    ("synthesis.report.terminal", "from ..pipeline import Result", "later station"),
    ("synthesis.agreement", "from .pipeline import Result", "later station"),
    ("synthesis.storage", "from .spec.model import Spec", "later station"),
    ("synthesis.certificate.claims", "from ..solve.bound import Bound", "knows the search"),
    ("synthesis.check.joint", "import numpy as np", "standard library"),
    ("synthesis.check.joint", "from ..spec.model import Spec", "standard library"),
    ("synthesis.check.joint", "from ..errors import ExitCode", "standard library"),
    ("synthesis.check.enclosure.joint", "from ...spec.model import Spec", "standard library"),
    ("synthesis.simulation.joint", "from ...models.closed_loop import ImpedanceLoop", "shares formulas"),
    ("synthesis.simulation.joint", "from ..problem.setting import Setting", "shares formulas"),
    ("synthesis.simulation.joint", "from ..certificate import claims", "shares formulas"),
    ("models.actuator", "if TYPE_CHECKING:\n    pass\nelse:\n    from ..synthesis import cli", "later station"),
]


@pytest.mark.parametrize(("module", "source", "reason"), OFFENDERS, ids=[f"{m}: {s}" for m, s, _ in OFFENDERS])
def test_an_import_against_the_order_is_seen(module: str, source: str, reason: str) -> None:
    assert reason in misplaced(source, module)[0]


def test_what_is_only_for_the_type_checker_is_no_import() -> None:
    quiet = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..pipeline import Result\n"
    assert misplaced(quiet, "synthesis.report.terminal") == []


def test_every_station_is_in_the_order() -> None:
    assert {layer(name) for name in MODULES if name != "synthesis"} == set(LAYERS)


@pytest.mark.parametrize("module", MODULES)
def test_a_file_imports_only_from_its_own_station_or_an_earlier_one(module: str) -> None:
    source, package = source_of(module)
    assert misplaced(source, module, package=package) == []


def cycle(graph: dict[str, set[str]]) -> list[str]:
    """A path of imports that ends where it began; empty if there is none."""
    done: set[str] = set()

    def visit(node: str, path: list[str]) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        for following in sorted(graph.get(node, set())):
            if found := visit(following, [*path, node]):
                return found
        done.add(node)
        return []

    return next((found for start in sorted(graph) if (found := visit(start, []))), [])


def test_no_module_imports_itself_in_a_circle() -> None:
    graph = {}
    for module in MODULES:
        source, package = source_of(module)
        graph[module] = {name for name in imports(source, module, package=package) if name in MODULES} - {module}
    assert sum(map(len, graph.values())) > 100, "the graph is nearly empty: imports are not seen"
    assert cycle(graph) == []
    graph["synthesis.errors"] = {"synthesis.cli"}
    assert cycle(graph)[0] == cycle(graph)[-1]


def loaded(code: str) -> set[str]:
    """Names in sys.modules after running code in a fresh interpreter."""
    script = f"import sys, json\n{code}\nsys.stdout.write('\\n' + json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def command(*arguments: str) -> str:
    return (
        f"sys.argv = {['robimp', *arguments]!r}\nfrom robimp.synthesis.cli import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert end.code in (0, 2), end.code"
    )


def test_the_proof_loads_no_solver() -> None:
    names = loaded("\n".join(f"import robimp.{name}" for name in MODULES if name.startswith("synthesis.certificate")))
    assert "robimp.synthesis.certificate.claims" in names and "flint" in names
    assert not names & {"cvxpy", "casadi"}
    assert not {name for name in names if name.startswith("robimp.synthesis.solve")}


@pytest.mark.parametrize("arguments", [("--help",), ("check", "--help"), ("check", "absent.json")])
def test_help_and_check_load_nothing_heavy(arguments: tuple[str, ...]) -> None:
    names = loaded(command(*arguments))
    assert "robimp.synthesis.cli" in names
    assert not names & set(HEAVY)


def test_a_whole_check_loads_nothing_heavy(tmp_path: Path) -> None:
    paper = ROOT / "examples" / "haninger2016-paper.yaml"
    synth = loaded(command("synth", str(paper), "-o", str(tmp_path)))
    assert synth & set(HEAVY), "a synthesis loads none either: the names are wrong"
    assert not synth & {"cvxpy", "casadi"}, "certifying given coefficients needs no solver"
    certificate = tmp_path / "certificate.json"
    code = command("check", str(certificate))
    assert not loaded(code) & set(HEAVY)
    assert not loaded(command("check", str(certificate), "--spec", str(paper))) & set(HEAVY)


def test_the_public_names_load_lazily() -> None:
    assert not loaded("import robimp.synthesis") & set(HEAVY)
    assert "cvxpy" not in loaded("from robimp.synthesis import check, load, parse, ExitCode")
    assert "casadi" in loaded("import robimp.synthesis.solve.nlp")


def too_long(source: str) -> bool:
    return len(source.splitlines()) > MOST_LINES


def test_no_file_is_too_long_to_read() -> None:
    assert too_long("x\n" * 301) and not too_long("x\n" * 300)
    files = [*MODULES.values(), *ROOT.glob("examples/*.py"), *ROOT.glob("benchmarks/**/*.py")]
    assert [str(file.relative_to(ROOT)) for file in files if too_long(file.read_text(encoding="utf-8"))] == []


def prints(source: str) -> list[int]:
    """Lines that print, or write to a standard stream."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            if called in ("print", "builtins.print", "sys.stdout.write", "sys.stderr.write"):
                found.append(node.lineno)
    return found


def test_only_the_command_lines_print() -> None:
    assert prints("def f():\n    print(1)") == [2]
    assert prints("import sys\nsys.stderr.write('x')") == [2]
    assert prints("console.print(1)  # print(1)") == []
    printing = {str(file.relative_to(ROOT)) for file in MODULES.values() if prints(file.read_text(encoding="utf-8"))}
    assert printing == PRINTERS


def machine_paths(text: str) -> list[str]:
    return [text[match.start() : match.end() + 20] for match in MACHINE_PATH.finditer(text)]


def test_nothing_names_a_path_of_one_machine() -> None:
    for place in ("home", "root", "work", "tmp"):
        assert machine_paths(f"open('/{place}/someone/file')") and machine_paths(f"see /{place}/x")
    assert machine_paths("https://example.org/work/x and a/tmp/b and ./tmp/c and rad/root") == []
    found = {}
    for file in sorted(ROOT.rglob("*")):
        parts = file.relative_to(ROOT).parts
        ours = not any(p in NOT_OURS or p.endswith((".egg-info", "_cache")) or p == ".hypothesis" for p in parts)
        if ours and file.is_file() and file.suffix in TEXT:
            text = file.read_text(encoding="utf-8", errors="replace")
            for line in machine_paths(text) + [p for p in (str(ROOT), str(Path.home())) if len(p) > 5 and p in text]:
                found.setdefault("/".join(parts), []).append(line)
    assert found == {}


def test_the_installed_version_is_the_one_written_down() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["version"] == version("robimp")


def test_every_package_is_installed() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    folders = {name for name, file in MODULES.items() if file.name == "__init__.py"}
    assert set(listed) == {f"robimp.{name}" for name in folders}
    assert len(listed) == len(set(listed)) >= 10
