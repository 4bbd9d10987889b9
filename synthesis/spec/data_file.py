"""Files a specification names: regular files inside its own folder, of bounded size."""

from __future__ import annotations

from pathlib import Path, PurePosixPath, PureWindowsPath

from ..errors import InputError, Location
from .fields import described, require
from .reader import MAX_BYTES
from .tree import Node, Scalar, shown


def data_file(node: Node, folder: Path | None) -> Path:
    """The file a specification names: a regular file inside the specification's folder, nowhere else."""
    where = node.where
    if not isinstance(node, Scalar) or not node.text:
        raise InputError(f"expected the name of a CSV file; found {described(node)}", where)
    message = "a specification without a file has no folder to look in; write `points:` instead of `file:`"
    if folder is None:
        raise InputError(message, where)
    for path in (PurePosixPath(node.text), PureWindowsPath(node.text)):
        inside = not (path.is_absolute() or path.drive or ".." in path.parts)
        advice = "put the file into the specification's folder"
        require(inside, f"expected a path below the specification's folder; found {shown(node.text)}; {advice}", where)
    target = folder / node.text
    try:
        inside = target.resolve().is_relative_to(folder.resolve())
        require(inside, "expected a file inside the specification's folder; this is a link to outside of it", where)
        require(target.exists(), f"expected a CSV file; {shown(node.text)} does not exist", where)
        # A pipe or a device would be read for ever.
        require(target.is_file(), f"expected a CSV file; {shown(node.text)} is no regular file", where)
    except (OSError, ValueError, RuntimeError) as error:  # ValueError: a null character; RuntimeError: a loop of links
        raise InputError(f"the file cannot be read: {_reason(error)}", where) from None
    return target


def read_bytes(path: Path, where: Location) -> bytes:
    """The content of a file, and one byte too many where it is too large; `where` it is named."""
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"the file cannot be read: {_reason(error)}", where) from None


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
