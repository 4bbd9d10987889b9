"""What a mutant of the checker is: one small change of its source, and how it takes the place of what runs."""

from __future__ import annotations

import ast
import copy
import importlib
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import EnumMeta
from functools import partial
from pathlib import Path
from types import FunctionType, ModuleType

PACKAGE = "robimp.synthesis.check"
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
    """One change: the file, the function, the line as it was, what was done, and what writes the whole new source."""

    file: str
    line: int
    place: str
    text: str
    change: str
    write: Callable[[], str] = field(repr=False)

    @property
    def source(self) -> str:
        return self.write()

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


def mutants(file: Path, folder: Path | None = None) -> Iterator[Mutant]:
    """Every mutant of a source file, named by its place in the folder; equal changes of one line are numbered."""
    seen = Counter[str]()
    for mutant in _mutants(file, folder):
        seen[mutant.key] += 1
        n = seen[mutant.key]
        yield replace(mutant, change=f"{mutant.change} #{n}") if n > 1 else mutant


def _mutants(file: Path, folder: Path | None) -> Iterator[Mutant]:
    name_of_file = file.relative_to(folder or file.parent).as_posix()
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
                        write = partial(_unparsed, tree, partial(_put, node, name, value, k), new, child)
                        yield Mutant(name_of_file, child.lineno, place, lines[child.lineno - 1].strip(), change, write)
                inner = child.name if isinstance(child, ast.FunctionDef | ast.ClassDef) else place
                yield from visit(child, inner, hidden)

    yield from visit(tree, "module", False)


def _unparsed(tree: ast.Module, put: Callable[[ast.AST | None], None], new: ast.AST | None, old: ast.AST) -> str:
    put(new)
    try:
        return ast.unparse(ast.fix_missing_locations(tree))
    finally:
        put(old)


def _put(node: ast.AST, name: str, value: object, k: int, new: ast.AST | None) -> None:
    if isinstance(value, list):
        value[k] = new
    else:
        setattr(node, name, new)


def transplant(mutant: Mutant) -> None:
    """Let the mutant's code, attributes and constants take the place of those that are running.

    Code is exchanged inside the functions that exist, so whoever holds one already runs the mutant."""
    parts = Path(mutant.file).with_suffix("").parts
    module = importlib.import_module(".".join([PACKAGE, *(part for part in parts if part != "__init__")]))
    new = {k: v for k, v in vars(module).items() if k.startswith("__")}
    exec(compile(mutant.source, mutant.file, "exec", dont_inherit=True), new)
    for name in [name for name, value in vars(module).items() if name not in new and not isinstance(value, ModuleType)]:
        if _users(name, vars(module).pop(name)):
            raise ImportError(name)
    for name, value in new.items():
        live = vars(module).get(name)
        if isinstance(value, type) and isinstance(live, type) and not isinstance(live, EnumMeta):
            if value is not live:
                _exchange(vars(value), live)
        elif not (_exchanged(value, live) or name.startswith("__") or repr(value) == repr(live)):
            for other in _users(name, live):
                setattr(other, name, value)


def _users(name: str, live: object) -> list[ModuleType]:
    """The checker's modules that have the same under a name."""
    return [m for key, m in sys.modules.items() if key.startswith(PACKAGE) and vars(m).get(name, m) is live]


def _exchange(new: Mapping[str, object], live: type) -> None:
    for name, value in new.items():
        plain = not name.startswith("__") and not hasattr(value, "__get__")
        if not _exchanged(value, vars(live).get(name)) and plain:
            setattr(live, name, value)


def _exchanged(value: object, live: object) -> bool:
    """Whether both are functions, methods, properties or caches; then the old one has the new one's code."""
    body, old = _function(value), _function(live)
    if body and old and body is not old:
        old.__code__, old.__defaults__, old.__kwdefaults__ = body.__code__, body.__defaults__, body.__kwdefaults__
    return bool(body and old)


def _function(value: object) -> FunctionType | None:
    for wrapper in ("__func__", "fget", "__wrapped__"):
        value = getattr(value, wrapper, value)
    return value if isinstance(value, FunctionType) else None
