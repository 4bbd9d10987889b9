"""Mutation testing of the checker: one small change at a time, run against its own tests; what survives is listed.

    python tests/evidence/mutation.py --budget 600 [--module positivity.py] [--processes 2] [--seed 0]

Survivors that are explained in survivors.md (one line each) are not reported again; 1 if another one survives.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

ROOT = Path(__file__).parents[2]
CHECK = Path("synthesis") / "check"
TESTS = ("tests/evidence/test_evidence_corpus.py", "tests/check")  # the quick ones first
SURVIVORS = Path(__file__).with_name("survivors.md")
SECONDS = 120.0  # for one mutant's tests; longer counts as noticed
SWAPS: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Add,),
    ast.FloorDiv: (ast.Mult,),
    ast.Div: (ast.Mult,),
    ast.Mod: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.LShift: (ast.RShift,),
    ast.RShift: (ast.LShift,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
    ast.USub: (ast.UAdd,),
}
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}
KEPT = {"strict", "frozen", "slots"}  # keywords of zip and dataclass: no behaviour of a checker


@dataclass(frozen=True)
class Mutant:
    """One change: the file, the function, the line as it was, what was done, and the whole new source."""

    file: str
    line: int
    place: str
    text: str
    change: str
    source: str

    @property
    def key(self) -> str:
        return f"`{self.file}` {self.place}: `{self.text}` — {self.change}"


def _edits(node: ast.AST) -> Iterator[tuple[str, ast.AST | None]]:
    """What may become of a node: a description and the new node (None: removed)."""
    new = copy.deepcopy(node)
    if isinstance(new, ast.Compare):
        for k, op in enumerate(new.ops):
            for other in SWAPS[type(op)]:
                changed = copy.deepcopy(new)
                changed.ops[k] = other()  # type: ignore[call-overload]
                yield f"{type(op).__name__} to {other.__name__}", changed
    elif isinstance(new, ast.BinOp | ast.BoolOp | ast.UnaryOp) and type(new.op) in SWAPS:
        was, (other,) = type(new.op).__name__, SWAPS[type(new.op)]
        new.op = other()  # type: ignore[assignment]
        yield f"{was} to {other.__name__}", new
    elif isinstance(new, ast.UnaryOp) and isinstance(new.op, ast.Not):
        yield "not removed", new.operand
    elif isinstance(new, ast.IfExp):
        new.body, new.orelse = new.orelse, new.body
        yield "branches exchanged", new
    elif isinstance(new, ast.Constant) and isinstance(new.value, bool):
        yield f"{new.value} to {not new.value}", ast.Constant(not new.value)
    elif isinstance(new, ast.Constant) and isinstance(new.value, int):
        for step in (1, -1):
            yield f"{new.value} to {new.value + step}", ast.Constant(new.value + step)
    elif isinstance(new, ast.Name) and new.id in NAMES and isinstance(new.ctx, ast.Load):
        yield f"{new.id} to {NAMES[new.id]}", ast.Name(NAMES[new.id], ast.Load())
    elif isinstance(new, ast.If | ast.While):
        for value in (True, False)[: 2 if isinstance(new, ast.If) else 0]:
            changed = copy.deepcopy(new)
            changed.test = ast.Constant(value)
            yield f"condition to {value}", changed
    elif isinstance(new, ast.Expr | ast.Assign | ast.AugAssign | ast.Raise | ast.Continue | ast.Break):
        if not (isinstance(new, ast.Expr) and isinstance(new.value, ast.Constant)):
            yield "removed", ast.Pass()
    elif isinstance(new, ast.Return) and new.value is not None:
        yield "returns None", ast.Return(ast.Constant(None))


def mutants(file: Path) -> Iterator[Mutant]:
    """Every mutant of a source file."""
    source = file.read_text(encoding="utf-8")
    lines, tree = source.splitlines(), ast.parse(source)

    def visit(node: ast.AST, place: str, quiet: bool) -> Iterator[Mutant]:
        for name, value in ast.iter_fields(node):
            for k, child in enumerate(value if isinstance(value, list) else [value]):
                if not isinstance(child, ast.AST):
                    continue
                hidden = quiet or (isinstance(child, ast.keyword) and child.arg in KEPT) or name == "annotation"
                hidden = hidden or (name == "returns") or isinstance(child, ast.JoinedStr)
                if hasattr(child, "lineno") and not hidden:
                    for change, new in _edits(child):
                        _put(node, name, value, k, new)
                        text = ast.unparse(ast.fix_missing_locations(tree))
                        _put(node, name, value, k, child)
                        yield Mutant(file.name, child.lineno, place, lines[child.lineno - 1].strip(), change, text)
                inner = child.name if isinstance(child, ast.FunctionDef | ast.ClassDef) else place
                yield from visit(child, inner, hidden)

    yield from visit(tree, "module", False)


def _put(node: ast.AST, name: str, value: object, k: int, new: ast.AST | None) -> None:
    if isinstance(value, list):
        value[k] = new
    else:
        setattr(node, name, new)


def workshop(folder: Path) -> Path:
    """A copy of what the checker's tests need, importable as `robimp` before any installed one."""
    for name in ("synthesis", "models", "tests/check", "tests/data"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "tests" / "evidence").mkdir()
    shutil.copy(ROOT / TESTS[0], folder / TESTS[0])
    shutil.copy(ROOT / "pyproject.toml", folder)
    (folder / "site" / "robimp").mkdir(parents=True)
    for name in ("synthesis", "models"):
        (folder / "site" / "robimp" / name).symlink_to(folder / name)
    return folder


def killed(folder: Path, tests: tuple[str, ...] = TESTS) -> str | None:
    """The first test that fails in a workshop, or None."""
    environment = {**os.environ, "PYTHONPATH": str(folder / "site"), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-xq", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist"]
    command += ["-o", "addopts=", "--hypothesis-seed=0", *tests]
    run = subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        out, _ = run.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)  # its own children too
        run.communicate()
        return "takes too long"
    if run.returncode == 0:
        return None
    said = [line for line in out.decode(errors="replace").splitlines() if line.startswith(("FAILED", "ERROR"))]
    return said[0][:100] if said else f"pytest ends with {run.returncode}"


def explained() -> set[str]:
    """Keys of the survivors that have an explanation."""
    if not SURVIVORS.exists():
        return set()
    lines = SURVIVORS.read_text(encoding="utf-8").splitlines()
    return {line[2:].rsplit(" ⇒ ", 1)[0] for line in lines if line.startswith("- ") and " ⇒ " in line}


def main() -> int:
    """Sample mutants within the budget and print the score and what survived."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budget", type=float, default=600, help="seconds (default 600)")
    parser.add_argument("--module", action="append", help="file name in synthesis/check (default all)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    files = sorted((ROOT / CHECK).glob("*.py"))
    todo = [m for file in files if not given.module or file.name in given.module for m in mutants(file)]
    random.Random(given.seed).shuffle(todo)
    known, counts, survivors, until = explained(), Counter[str](), [], time.monotonic() + given.budget
    with tempfile.TemporaryDirectory() as folder:
        free: Queue[Path] = Queue()
        for k in range(given.processes):
            free.put(workshop(Path(folder) / str(k)))
        unchanged = free.get()
        if fault := killed(unchanged):
            sys.stdout.write(f"the tests fail without any change: {fault}\n")
            return 2
        free.put(unchanged)

        def run(mutant: Mutant) -> tuple[Mutant, str | None] | None:
            if time.monotonic() > until:
                return None
            place = free.get()
            target = place / CHECK / mutant.file
            before = target.read_text(encoding="utf-8")
            target.write_text(mutant.source, encoding="utf-8")
            try:
                return mutant, killed(place)
            finally:
                target.write_text(before, encoding="utf-8")
                free.put(place)

        with ThreadPoolExecutor(given.processes) as pool:
            for done in pool.map(run, todo):
                if done is None:
                    continue
                mutant, by = done
                how = "noticed" if by else "survived, explained" if mutant.key in known else "survived"
                counts[how] += 1
                if how == "survived":
                    survivors.append(mutant)
                    sys.stdout.write(f"{mutant.file}:{mutant.line}\n- {mutant.key} ⇒ \n")
                    sys.stdout.flush()
    tried = sum(counts.values())
    sys.stdout.write(f"{len(todo)} mutants, {tried} tried: " + ", ".join(f"{n} {k}" for k, n in counts.items()) + "\n")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
