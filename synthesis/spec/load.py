"""A specification file to `Spec`."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeVar, cast

from ..errors import InputError, Location
from . import demands, joint
from .fields import described, entries, integer, require, word
from .model import Spec
from .reader import MAX_BYTES, read_tree
from .tree import Mapping, Node, Scalar
from .uncertainty import uncertainty as read_uncertainty
from .units import MECHANICS

_OPTIONAL = ("sampling",)
_REQUIRED = tuple(key for key in Spec.model_fields if key not in _OPTIONAL)  # no other section has a default

T = TypeVar("T")


def load_spec(path: str | Path) -> Spec:
    """The specification in a YAML file.

    Raises:
        InputError: file, line, column and key of the first fault, what was expected, what was found, what to do.
    """
    path = Path(path)
    where = Location(str(path))
    try:
        # A pipe or a device would be read for ever.
        require(path.is_file() or not path.exists(), "expected a specification file; this is no regular file", where)
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"the file cannot be read: {reason}", where) from None
    return build_spec(read_tree(data, str(path)), path.parent)


def parse_spec(text: str | bytes, file: str = "<string>") -> Spec:
    """The specification in a YAML text; `file` names it in errors. A text has no folder, so it names no data files.

    Raises:
        InputError: see `load_spec`.
    """
    data = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    return build_spec(read_tree(data, file))


def build_spec(root: Node, folder: Path | None = None) -> Spec:
    """The specification that a tree of text describes; of several faults, the one that stands first in the file.

    Data files are looked for in `folder`; None: nowhere.
    """
    section = _top(root)
    sections = _Sections()
    read = sections.read
    name = read(lambda: _name(section["name"]))
    motion = read(lambda: cast(Literal["rotary", "linear"], word(section["motion"], *MECHANICS)))
    units = MECHANICS[motion or "rotary"]
    plant = read(lambda: joint.plant(section["plant"], units))
    actuator = read(lambda: joint.actuator(section["actuator"], units))
    loose = section["uncertainty"]
    uncertainty = read(lambda: read_uncertainty(loose, units, plant, actuator, folder), loose.where) if plant else None
    impedance = read(lambda: joint.impedance(section["impedance"], units, plant)) if plant else None
    sampling = read(lambda: joint.sampling(section["sampling"])) if "sampling" in section else None
    controller = read(lambda: demands.controller(section["controller"]))
    objective = read(lambda: demands.objective(section["objective"]))
    constraints = read(lambda: demands.constraints(section["constraints"], units, uncertainty))
    sections.raise_first()
    return Spec.model_validate(
        {
            "robimp": 1,
            "name": name,
            "motion": motion,
            "plant": plant,
            "uncertainty": uncertainty,
            "actuator": actuator,
            "impedance": impedance,
            "controller": controller,
            "objective": objective,
            "constraints": constraints,
            "sampling": sampling,
        }
    )


def place_of(path: str | Path, key: str) -> Location:
    """Where a dotted key stands in a file, or the last part of it that does; without line if the file is no tree."""
    path = Path(path)
    where = Location(str(path))
    try:
        node = read_tree(path.read_bytes(), str(path))
    except (InputError, OSError):
        return where
    for part in key.split("."):
        if not isinstance(node, Mapping) or part not in node.entries:
            break
        place, node = node.entries[part]
        where = Location(place.file, place.line, place.column)
    return where


class _Sections:
    """Reads section after section, keeping the fault of each."""

    def __init__(self) -> None:
        self.faults: list[tuple[Location | None, InputError]] = []

    def read(self, build: Callable[[], T], where: Location | None = None) -> T | None:
        """What `build` reads; `where` it stands in the specification if its faults may lie in another file."""
        try:
            return build()
        except InputError as fault:
            place = fault.location
            foreign = where and place and place.file != where.file
            self.faults.append((where if foreign else place, fault))
            return None

    def raise_first(self) -> None:
        def position(found: tuple[Location | None, InputError]) -> tuple[int, int]:
            place = found[0]
            return (place.line or 0, place.column or 0) if place else (0, 0)

        if self.faults:
            raise min(self.faults, key=position)[1]


def _top(root: Node) -> dict[str, Node]:
    # The version comes first: the keys of a later format are not misspelt keys of this one.
    if isinstance(root, Mapping) and "robimp" in root.entries:
        version = root.entries["robimp"][1]
        what = "the format version 1"
        message = f"expected {what}; found {described(version)}; this release reads no other; write robimp: 1"
        require(integer(version, what) == 1, message, version.where)
    return entries(root, _REQUIRED, optional=_OPTIONAL)


def _name(node: Node) -> str:
    # It becomes the name of the output folder.
    valid = isinstance(node, Scalar) and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", node.text)
    rule = "1 to 64 letters, digits, dots, dashes or underscores, the first a letter or digit"
    better = re.sub(r"[^A-Za-z0-9._-]+", "-", node.text).strip("._-")[:64] if isinstance(node, Scalar) else ""
    advice = f"; write {better or 'my-joint'}"
    require(bool(valid), f"expected a name of {rule}; found {described(node)}{advice}", node.where)
    return cast(Scalar, node).text
