"""Files a specification names: regular files inside its own folder, of bounded size."""

from __future__ import annotations

from pathlib import Path, PurePosixPath, PureWindowsPath

from ..errors import InputError, Location
from .fields import described, require
from .reader import MAX_BYTES
from .tree import Node, Scalar, shown

MAX_FILES = 100


def data_file(node: Node, folder: Path | None) -> Path:
    """The file a specification names: a regular file inside the specification's folder, nowhere else."""
    name, home = _name(node, folder)
    return _regular(home, name, node.where)


def data_files(node: Node, folder: Path | None) -> dict[str, Path]:
    """The files a name or a pattern (`frf/*.csv`) stands for, in the order of their names; each as `data_file`."""
    name, home = _name(node, folder)
    if not any(sign in name for sign in "*?["):
        return {PurePosixPath(name).as_posix(): _regular(home, name, node.where)}
    require("**" not in name, f"expected a pattern without `**`; found {shown(name)}; name the folders", node.where)
    try:
        found = sorted(path.relative_to(home).as_posix() for path in home.glob(name))
    except (OSError, ValueError, RuntimeError, NotImplementedError) as error:
        raise InputError(f"the files cannot be looked for: {_reason(error)}", node.where) from None
    require(
        bool(found),
        f"expected CSV files; nothing here is named {shown(name)}; paths begin at the specification's folder",
        node.where,
    )
    message = f"expected at most {MAX_FILES} files; {shown(name)} names {len(found)}; put several records into one"
    require(len(found) <= MAX_FILES, message, node.where)
    return {name: _regular(home, name, node.where) for name in found}


def read_bytes(path: Path, where: Location) -> bytes:
    """The content of a file, and one byte too many where it is too large; `where` it is named."""
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"the file cannot be read: {_reason(error)}", where) from None


def _name(node: Node, folder: Path | None) -> tuple[str, Path]:
    """A name that leads nowhere but below the folder."""
    where = node.where
    if not isinstance(node, Scalar) or not node.text:
        raise InputError(f"expected the name of a CSV file; found {described(node)}", where)
    message = "a specification without a file has no folder to look in; write `table:` with `points:`"
    if folder is None:
        raise InputError(message, where)
    for path in (PurePosixPath(node.text), PureWindowsPath(node.text)):
        inside = not (path.is_absolute() or path.drive or ".." in path.parts)
        advice = "put the file into the specification's folder"
        require(inside, f"expected a path below the specification's folder; found {shown(node.text)}; {advice}", where)
    return node.text, folder


def _regular(folder: Path, name: str, where: Location) -> Path:
    target = folder / name
    try:
        inside = target.resolve().is_relative_to(folder.resolve())
        require(inside, "expected a file inside the specification's folder; this is a link to outside of it", where)
        require(
            target.exists(),
            f"expected a CSV file; {shown(name)} does not exist; its path begins at the specification's folder",
            where,
        )
        # A pipe or a device would be read for ever.
        require(target.is_file(), f"expected a CSV file; {shown(name)} is no regular file", where)
    except (OSError, ValueError, RuntimeError) as error:  # ValueError: a null character; RuntimeError: a loop of links
        raise InputError(f"the file cannot be read: {_reason(error)}", where) from None
    return target


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
