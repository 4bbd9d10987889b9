"""The run of a map: cells to whoever is idle, each started from its neighbour, each finished one into the journal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError, UndecidedError
from ..interruption import demand_none
from ..spec.model import Spec
from ..storage import write_atomic
from .axis import Axis
from .cell import Cell, Start, Status, Task, solve_cell
from .journal import Journal
from .plane import Index, Plane
from .result import Map, certificate_name
from .workers import workers

ATTEMPTS = 2  # a worker may be killed for lack of memory once; twice is the cell's own doing
LOOK_AROUND = 0.5  # s between looks for a Ctrl-C that was swallowed

Progress = Callable[[int, int], None]  # cells done, cells in error
Answer = tuple[Cell, bytes | None]


def map_plane(
    spec: Spec | str | Path,
    axes: Mapping[str, str] | tuple[Axis, Axis],
    folder: str | Path,
    *,
    processes: int | None = None,
    dask: str | None = None,
    time_limit: float | None = None,
    certificates: bool = False,
    progress: Progress = lambda done, failed: None,
) -> Map:
    """Synthesise at every cell of a plane of two keys, `{"impedance.stiffness": "0.5:10:20", …: "A:B:N:log"}`.

    Finished cells are kept in `folder`/map.journal: the same call resumes after whatever ended it. processes: None for
    all cores; dask: address of a scheduler instead; time_limit [s] bounds the search in each cell; certificates:
    write one file for each proven cell.

    Raises: InputError for axes, cells or a folder that cannot be used; MismatchError for the journal of another map;
    UndecidedError when a cluster gives up. What happens in a cell is in the cell.

    >>> from robimp.synthesis import map_plane
    >>> axes = {"impedance.stiffness": "1:9:2", "impedance.damping": "0.2:0.4:2"}
    >>> map_plane("examples/haninger2016-paper.yaml", axes, "map", processes=1)
    <Map haninger2016-paper: 4 cells, 2 proven, 2 refuted>
    """
    if not isinstance(axes, tuple):
        axes = _two([Axis.parse(key, values) for key, values in axes.items()])
    if processes is not None and processes < 1:
        raise InputError("processes: expected at least 1")
    plane, folder = Plane.of(spec, axes), Path(folder)
    options = {"time_limit": time_limit, "certificates": certificates}
    with Journal(folder, plane, options) as journal:
        todo = sorted((index for index in plane if index not in journal.finished), key=_remaining)
        if todo:
            with workers(processes, dask) as (executor, size):
                run = _Run(plane, folder, journal, executor, size, options, progress)
                run.solve(todo)
        return Map(plane, dict(journal.finished), certificates)


def _remaining(index: Index) -> tuple[int, int]:
    """Cells by how many follow them along their row, most first: no long chain is left for the end."""
    return index[1], index[0]


def _two(axes: list[Axis]) -> tuple[Axis, Axis]:
    if len(axes) != 2:
        raise InputError(f"a map has two axes; {len(axes)} given")
    return axes[0], axes[1]


@dataclass
class _Run:
    """One run, until every cell of `todo` is in the journal."""

    plane: Plane
    folder: Path
    journal: Journal
    executor: Executor
    size: int
    options: dict[str, Any]
    progress: Progress
    failed: int = 0
    attempts: dict[Index, int] = field(default_factory=dict)

    def solve(self, todo: list[Index]) -> None:
        """Keep every worker busy with cells whose neighbour is done."""
        running: dict[Future[Answer], Index] = {}
        self.progress(len(self.journal.finished), 0)
        try:
            while todo or running:
                for index in list(self._ready(todo))[: self.size - len(running)]:
                    todo.remove(index)
                    running[self._submit(index)] = index
                demand_none()
                for future in wait(running, timeout=LOOK_AROUND, return_when=FIRST_COMPLETED).done:
                    index = running.pop(future)
                    answer = self._answer(index, future)
                    if answer is None:
                        todo.insert(0, index)
                    else:
                        self._keep(*answer)
        finally:
            for future in running:
                future.cancel()

    def _ready(self, todo: list[Index]) -> Iterator[Index]:
        done = self.journal.finished
        return (index for index in todo if (parent := self.plane.parent(index)) is None or parent in done)

    def _submit(self, index: Index) -> Future[Answer]:
        task = Task(index, self.plane.specs[index], self._start(index), self.options["time_limit"])
        return self.executor.submit(solve_cell, task)

    def _start(self, index: Index) -> Start | None:
        """The controller of the nearest ancestor that has one."""
        parent = self.plane.parent(index)
        while parent is not None:
            start = self.journal.finished[parent].start
            if start is not None:
                return start
            parent = self.plane.parent(parent)
        return None

    def _answer(self, index: Index, future: Future[Answer]) -> Answer | None:
        """What a worker answered; None: try again. A worker that dies costs its cell only."""
        try:
            return future.result()
        except BrokenProcessPool:
            self.attempts[index] = self.attempts.get(index, 0) + 1
            if self.attempts[index] < ATTEMPTS:
                return None
            return Cell(index, Status.ERROR, cause="worker died", reason=f"its worker died {ATTEMPTS} times"), None
        except CancelledError:
            raise UndecidedError("the cluster dropped the work; what is finished is kept: run the same again") from None
        except Exception as error:  # a cluster's own way to say that a worker died
            name = type(error).__name__
            return Cell(index, Status.ERROR, cause=name, reason=f"no answer: {name}: {error}"), None

    def _keep(self, cell: Cell, certificate: bytes | None) -> None:
        """The certificate first: a cell in the journal is finished."""
        if certificate is not None and self.options["certificates"]:
            write_atomic(self.folder / certificate_name(cell.index), certificate)
        self.journal.add(cell)
        self.failed += cell.status is Status.ERROR
        self.progress(len(self.journal.finished), self.failed)
