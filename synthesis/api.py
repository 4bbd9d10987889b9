"""The commands for Python: every function does what `robimp` and its name do, and loads what it needs when called."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .errors import ExitCode, InputError, Location, MismatchError, UndecidedError

if TYPE_CHECKING:
    from .challenge import Reality
    from .design import Shared
    from .judgement import Judgement
    from .pipeline import Result
    from .replay import Replay
    from .solve.bound import Bound
    from .spec.model import Polynomials, Spec


Progress = Callable[[str], None]
File = str | Path


def _quiet(_: str) -> None:
    pass


def _spec(spec: Spec | File) -> Spec:
    return load(spec) if isinstance(spec, str | Path) else spec


def load(path: File) -> Spec:
    """The specification in a YAML file; data files it names are looked for in its folder.

    Raises: InputError with file, line, column and key of the first mistake, and what to write instead.

    >>> from robimp.synthesis import load
    >>> load("examples/haninger2016-paper.yaml")
    <Spec haninger2016-paper: rotary, series-elastic, dob>
    """
    from .spec import load_spec

    return load_spec(path)


def parse(text: str | bytes, file: str = "<string>") -> Spec:
    """The specification in a YAML text, which names no data files; `file` names it in errors.

    Raises: InputError, as `load`.

    >>> from robimp.synthesis import init, parse
    >>> parse(init("arm", "ideal"))
    <Spec arm: rotary, ideal, dob>
    """
    from .spec import parse_spec

    return parse_spec(text, file)


def init(name: str, actuator: Literal["series-elastic", "ideal"] = "series-elastic") -> str:
    """A commented specification to start from, as YAML; `robimp init`.

    Raises: InputError for a name that a specification cannot have.

    >>> from robimp.synthesis import init
    >>> "inertia:" in init("arm")
    True
    """
    from .spec.template import template

    if actuator not in ("series-elastic", "ideal"):
        raise InputError(f"expected series-elastic or ideal; found {actuator!r:.40}", Location("actuator"))
    text = template(name, actuator)
    parse(text, "name")
    return text


def schema() -> dict[str, Any]:
    """The JSON schema of specifications; `robimp schema`.

    >>> from robimp.synthesis import schema
    >>> schema()["properties"]["robimp"]["const"]
    1
    """
    from .spec import json_schema

    return json_schema()


def synthesize(
    spec: Spec | File,
    progress: Progress = _quiet,
    *,
    controller: Any = None,
    time_limit: float | None = None,
    starts: Sequence[tuple[Polynomials, float]] = (),
    shared: Shared | None = None,
    seed: int = 0,
) -> Result:
    """Find (or take) a controller, prove every claim about it, have the proof re-checked, simulate it; `robimp synth`.

    spec: a specification, or its file. controller: certify this one instead of what the specification asks for: a
    `control.TransferFunction` or a pair (numerator, denominator) of coefficients [rad/s], of Q for a disturbance
    observer, of C_imp for dynamic-error feedback. time_limit [s] bounds the search. starts: controllers of similar
    joints with their ω_B [rad/s], for the search to begin from as well; where the force filter is free, with F in them.
    shared: what an earlier search on the same joint, of another order, has found. seed: of the random starts; the same
    seed, the same digits.

    Raises: InfeasibleError with the constraint and frequency; UndecidedError when the search ends without a proven
    controller; InputError for what cannot be used; RobimpError when prover, checker and simulation disagree.

    >>> from robimp.synthesis import synthesize
    >>> result = synthesize("examples/haninger2016-paper.yaml", controller=([2000], [1, "70.75", 2500]))
    >>> result
    <Result haninger2016-paper: PROVEN, ω_B ≥ 8.87571 rad/s, 11 claims>
    >>> result.Q.to_control().dcgain().item()
    0.8
    """
    from . import pipeline

    asked = _spec(spec)
    if controller is not None:
        from .spec.given import given

        wanted = {"coefficients": given(controller, asked.controller.type), "order": None, "form": None}
        asked = asked.model_copy(update={"controller": asked.controller.model_copy(update=wanted)})
    return pipeline.synthesize(asked, progress, time_limit=time_limit, starts=starts, shared=shared, seed=seed)


def bound(spec: Spec | File, terms: int | None = None, progress: Progress = _quiet) -> Bound:
    """The bandwidth no controller in a large basis beats, and which constraint sets it, where; `robimp bound`.

    terms: size of the basis, by default as large as it takes. A solver's figure on a grid, not a proof.

    Raises: InfeasibleError with the constraint and frequency; UndecidedError where nothing in the basis will do.

    >>> from robimp.synthesis import bound
    >>> limit = bound("examples/haninger2016-paper.yaml", terms=16)
    >>> 40 < limit.omega_B < 60
    True
    """
    from .interruption import demanding
    from .pipeline import setting_of
    from .solve.bound import bound as convex_bound
    from .solve.infeasible import impossible, unattainable

    setting = setting_of(_spec(spec))
    reason = impossible(setting)
    if reason is not None:
        raise reason.error()
    limit = convex_bound(setting, terms, demanding(progress))
    if limit is None:
        unmet = unattainable(setting)
        raise (
            unmet.error()
            if unmet
            else UndecidedError("no Q̃ in the basis satisfies the constraints, by the solver's word")
        )
    return limit


def judge(
    certificate: File, *, spec: Spec | File | None = None, controller: File | None = None, time_limit: float = 60.0
) -> Judgement:
    """Re-prove a certificate's claims, and compare it with the specification and controller in use; `robimp check`.

    time_limit [s]. A certificate of something else is a mismatch, whatever it proves.

    Raises: InputError for a specification or controller file that cannot be read.

    >>> from robimp.synthesis import judge
    >>> judge("certificate.json", spec="examples/haninger2016-paper.yaml")
    <Judgement certificate.json: PROVEN, ω_B ≥ 8.87571 rad/s  10 claims, of this specification>
    """
    from .check.reader import MAX_BYTES
    from .controller_file import MAX_BYTES as MAX_CONTROLLER
    from .controller_file import read_controller
    from .judgement import judge as judged
    from .judgement import unreadable
    from .spec import canonical
    from .storage import bounded_bytes

    asked = None if spec is None else canonical(_spec(spec))
    law = None
    if controller is not None:
        law = read_controller(bounded_bytes(Path(controller), MAX_CONTROLLER), str(controller))
    try:
        data = bounded_bytes(Path(certificate), MAX_BYTES)
    except InputError as error:
        return unreadable(str(certificate), error.message)
    return judged(str(certificate), data, asked, law, time_limit)


def simulate(
    certificate: File | Result,
    *,
    loads: int = 10_000,
    seed: int = 0,
    reality: Reality | None = None,
    progress: Progress = _quiet,
) -> Replay:
    """Move a certified joint in the time domain and attack every claim; `robimp simulate`.

    certificate: a file, or a result. loads: how many are drawn, with `seed`; 0: only the corners of the box, no
    attacks. reality: friction, limits, an encoder, noise, a rate, single precision, which the certificate leaves out
    and the joints drawn then meet as well, for information: `Reality(Imperfections(load_friction=0.05), rate=1000)` of
    `robimp.synthesis.challenge`.

    Raises: InputError for a file that is no certificate, or a reality that cannot be; MismatchError for a certificate
    that is not what it says.

    >>> from robimp.synthesis import simulate
    >>> simulate("certificate.json", loads=0)
    <Replay: agrees, 15 trials>
    """
    from .check import check_bytes
    from .check.reader import MAX_BYTES
    from .replay import replay
    from .storage import bounded_bytes

    named = isinstance(certificate, str | Path)
    file = str(certificate) if named else certificate.spec.name  # type: ignore[union-attr]
    data = bounded_bytes(Path(file), MAX_BYTES) if named else certificate.certificate_bytes()  # type: ignore[union-attr]
    checked = check_bytes(data)
    if checked.exit_code == ExitCode.INPUT:
        raise InputError(checked.message, Location(file))
    if checked.exit_code == ExitCode.MISMATCH:
        raise MismatchError(f"{file}: {checked.message}")
    return replay(json.loads(data), checked, file, progress, count=loads, seed=seed, reality=reality)
