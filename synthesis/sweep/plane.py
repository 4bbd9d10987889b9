"""The plane of a map: a specification with two of its keys replaced, cell by cell."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from ..errors import InputError, Location
from ..spec.canonical_form import canonical, spec_sha256
from ..spec.load import build_spec, load_spec
from ..spec.model import Spec
from ..spec.reader import read_tree
from ..spec.tree import Mapping, Node, Scalar
from .axis import Axis

Index = tuple[int, int]  # of a cell: along the first axis, along the second


@dataclass(frozen=True)
class Plane:
    """A specification, as a tree of text so that `±20 %` and `nominal` follow what is varied, and two axes."""

    spec: Spec
    root: Node
    folder: Path | None
    axes: tuple[Axis, Axis]

    @classmethod
    def of(cls, spec: Spec | str | Path, axes: tuple[Axis, Axis]) -> Plane:
        """Of a specification or its file. Raises: InputError for one that cannot be read, or equal keys."""
        if axes[0].key == axes[1].key:
            raise InputError(f"both axes vary {axes[0].key}: name two different keys")
        if isinstance(spec, Spec):
            text = json.dumps(canonical(spec), indent=1, ensure_ascii=False).encode()
            return cls(spec, read_tree(text, spec.name), None, axes)
        path = Path(spec)
        loaded = load_spec(path)
        return cls(loaded, read_tree(path.read_bytes(), str(path)), path.parent, axes)

    def __iter__(self) -> Iterator[Index]:
        """Every cell, row by row."""
        first, second = self.axes
        return ((i, j) for i in range(len(first.values)) for j in range(len(second.values)))

    def __len__(self) -> int:
        return len(self.axes[0].values) * len(self.axes[1].values)

    def values(self, index: Index) -> dict[str, str]:
        """What a cell sets: key → exact text."""
        return {axis.key: axis.values[k] for axis, k in zip(self.axes, index, strict=True)}

    @cached_property
    def specs(self) -> dict[Index, Spec]:
        """The specification of every cell. Raises: InputError naming the key, before anything long is computed."""
        return {index: self._cell(index) for index in self}

    def _cell(self, index: Index) -> Spec:
        root = self.root
        for key, value in self.values(index).items():
            where = Location(f"{key}={value}", key=key)
            root = _replaced(root, key.split("."), Scalar(value, True, where), where)
        return build_spec(root, self.folder)

    def parent(self, index: Index) -> Index | None:
        """The neighbour whose controller a cell's search starts from; the same whatever finishes first.

        Along the second axis, and along the first at its beginning. None: the first cell, or a given controller.
        """
        if self.spec.controller.coefficients is not None or index == (0, 0):
            return None
        i, j = index
        return (i, j - 1) if j else (i - 1, 0)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over all cells' specifications."""
        return hashlib.sha256("".join(spec_sha256(self.specs[index]) for index in self).encode()).hexdigest()

    def to_json(self) -> dict[str, object]:
        """What a map is of."""
        return {"spec": canonical(self.spec), "axes": [axis.to_json() for axis in self.axes], "digest": self.digest}


def _replaced(node: Node, keys: list[str], value: Scalar, where: Location) -> Node:
    """The tree with one leaf replaced; a key may be new in an existing section. Raises: InputError."""
    if not keys:
        if isinstance(node, Mapping):
            raise InputError("expected the key of one number; this is a section", where)
        return value
    if not isinstance(node, Mapping) or (len(keys) > 1 and keys[0] not in node.entries):
        raise InputError(f"the specification has no section that holds `{keys[0]}`", where)
    if keys[0] not in node.entries:
        return replace(node, entries=node.entries | {keys[0]: (where, value)})
    place, child = node.entries[keys[0]]
    return replace(node, entries=node.entries | {keys[0]: (place, _replaced(child, keys[1:], value, where))})
