"""From a certificate to files for a drive: check, discretise, prove again, write."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...models.rational import exact
from ...models.sampling import Hold
from ..check import check_bytes
from ..check.reader import MAX_BYTES
from ..errors import ExitCode, InputError, MismatchError, RefutedError, RobimpError, UndecidedError
from ..interruption import demanding
from ..notebook import card
from ..problem.setting import Setting
from ..report.cards import tone
from ..spec import from_canonical
from ..spec.units import RATE, parse_quantity
from ..storage import bounded_bytes, write_atomic
from ..written import polynomials
from .carried import Carried, bandwidth, exit_code, lost
from .law import Law, discretised
from .proofs import carried_over
from .sections import DTYPE, Sections
from .targets import TARGETS, Subject, demand_rate, document, files_of

if TYPE_CHECKING:
    import control

Progress = Callable[[str], None]
CODES: dict[int, type[RobimpError]] = {2: InputError, 4: RefutedError, 5: UndecidedError, 6: MismatchError}


@dataclass(frozen=True, repr=False)
class Exported:
    """A controller ready for a drive: its law, what was proven of it, and the text of every file by name."""

    subject: Subject
    target: str

    def __repr__(self) -> str:
        missing = ", ".join(f"{each.id} {each.form}" for each in lost(self.claims))
        found = f"not proven: {missing}" if missing else "every required claim proven"
        return f"<Exported {self.subject.name}: {float(self.law.rate):g} Hz, {self.law.precision}, {found}>"

    def _repr_html_(self) -> str:
        rows = [
            ("law", f"{float(self.law.rate):g} Hz, {self.law.precision} precision"),
            ("timing", self.subject.timing),
            ("bandwidth", bandwidth(self.claims)),
            ("certificate", self.subject.certificate),
        ]
        claims = [(each.id, each.form, "required" if each.required else "reported", each.said) for each in self.claims]
        badge = "NOT PROVEN" if lost(self.claims) else "PROVEN"
        headings = ("claim", "form", "role", "for this code")
        return card(self.subject.name, badge, tone(self.exit_code), rows, (headings, claims))

    @property
    def law(self) -> Law:
        """The difference equations, every number as in the files."""
        return self.subject.law

    @property
    def claims(self) -> tuple[Carried, ...]:
        """What became of every claim of the certificate."""
        return self.subject.carried

    @property
    def exit_code(self) -> ExitCode:
        """PROVEN when every required claim holds for the exported controller too."""
        return exit_code(self.claims)

    @property
    def files(self) -> dict[str, str]:
        """Text of every file by its name; `export.json` is among them for every target."""
        return files_of(self.subject, self.target)

    def to_json(self) -> dict[str, Any]:
        """The content of `export.json`."""
        return document(self.subject)

    def to_control(self) -> dict[str, control.TransferFunction]:
        """Compensator and filters as discrete `control.TransferFunction`, of the sampling period."""
        return {name: transfer_function(sections, self.law) for name, sections in self.law.filters.items()}

    def write(self, folder: str | Path) -> tuple[Path, ...]:
        """Write every file into a folder, each completely or not at all. Raises: InputError."""
        paths = []
        for name, text in self.files.items():
            path = Path(folder) / name
            write_atomic(path, text.encode())
            paths.append(path)
        return tuple(paths)


def transfer_function(sections: Sections, law: Law) -> control.TransferFunction:
    """A cascade as one `control.TransferFunction` of z; its coefficients are products, rounded to doubles."""
    import control
    from scipy.signal import sos2tf

    num, den = sos2tf(sections.sos) if sections.sections else ([1.0], [1.0])
    return control.tf(num, den, dt=float(1 / law.rate))


def export(
    certificate: str | Path | bytes,
    *,
    target: str = "c",
    rate: Fraction | float | str | None = None,
    precision: str = "double",
    time_limit: float = 60.0,
    progress: Progress = lambda _: None,
) -> Exported:
    """The certified controller as discrete second-order sections, with the claims that carry over proven again.

    Args:
        certificate: a file, or its bytes; it is checked first.
        target: `c`, `json`, `control` or `ros2`.
        rate: samples per second [Hz], or a text such as "1 kHz"; needed where the specification has no `sampling`,
            which otherwise decides.
        precision: `double` or `float`, of the coefficients and of the C code.
        time_limit: for the check [s]; the proofs for the discrete controller, which follow, have none.
        progress: called with what is being done.

    Returns: the export, whose `exit_code` says whether every required claim carried over; nothing is written yet.

    Raises: InputError for an unusable certificate, target, rate or precision; RefutedError, UndecidedError or
    MismatchError for a certificate that does not check.

    >>> from robimp.synthesis.export import export
    >>> done = export("certificate.json", target="c", rate="1 kHz")
    >>> done
    <Exported haninger2016-paper: 1000 Hz, double, every required claim proven>
    >>> sorted(done.files)
    ['export.json', 'haninger2016_paper.c', 'haninger2016_paper.h']
    >>> done.to_control()["compensator"].dt
    0.001
    """
    _demand(target in TARGETS, f"--target: expected {', '.join(TARGETS)}; found {target}")
    _demand(precision in DTYPE, f"--precision: expected {', '.join(DTYPE)}; found {precision}")
    hertz = _rate(rate)
    progress = demanding(progress)
    data = certificate if isinstance(certificate, bytes) else bounded_bytes(Path(certificate), MAX_BYTES)
    progress("checking the certificate")
    checked = check_bytes(data, time_limit=time_limit)
    if checked.exit_code != ExitCode.PROVEN:
        raise CODES.get(checked.exit_code, RobimpError)(f"not exported, it does not check: {checked.message}")
    content = json.loads(data)
    spec = from_canonical(content["spec"])
    setting, hertz = _sampled(Setting.of(spec), hertz)
    demand_rate(target, hertz)
    coefficients = polynomials(content["controller"]["Q" if spec.controller.type == "dob" else "C"])
    C = setting.compensator(coefficients)
    law = discretised(setting, C, hertz, precision, float(Fraction(content["bandwidth"]["proven"])))
    carried = carried_over(setting, C, law, content["claims"], progress)
    return Exported(
        Subject(
            setting=setting,
            law=law,
            carried=carried,
            certificate=content["end"]["body_sha256"],
            spec_sha256=content["spec_sha256"],
            assumed_hold=spec.sampling is None,
            version=version("robimp"),
        ),
        target,
    )


def _rate(given: Fraction | float | str | None) -> Fraction | None:
    """Samples per second [Hz] of a number or a text. Raises: InputError."""
    if given is None:
        return None
    try:
        rate = parse_quantity(given, RATE) if isinstance(given, str) else Fraction(given)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"--rate: {error}") from error
    _demand(rate > 0, "--rate: expected samples per second, above 0")
    return rate


def _sampled(setting: Setting, rate: Fraction | None) -> tuple[Setting, Fraction]:
    """The setting with the hold of the exported controller, and its rate [Hz]. Raises: InputError."""
    sampling = setting.spec.sampling
    if sampling is not None:
        if rate is not None and rate != sampling.rate:
            raise InputError(
                f"--rate: the certificate is for {float(sampling.rate):g} Hz (sampling.rate); leave --rate out, "
                "or certify the other rate"
            )
        return setting, sampling.rate
    if rate is None:
        raise InputError(
            "--rate: the specification has no `sampling`; say the rate of your control loop, --rate '1 kHz'"
        )
    hold = Hold(1 / exact(rate), exact(0))
    return setting.held(hold), rate


def _demand(holds: bool, message: str) -> None:
    if not holds:
        raise InputError(message)
