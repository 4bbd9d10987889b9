"""A certificate back in the time domain: its controller on its own specification's joint, against its own claims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from .agreement import Agreement, compare
from .certificate.claims import certify
from .certificate.document import document, verdict
from .check import Verdict
from .errors import InputError, MismatchError
from .interruption import demanding
from .notebook import card
from .pipeline import realizable, setting_of
from .recheck import VERDICT_CODE
from .simulation import Trials, verify
from .spec import from_canonical
from .written import claims_of, polynomials

if TYPE_CHECKING:
    from .challenge import Challenge, Reality
    from .simulation.experiments import Experiment


@dataclass(frozen=True, eq=False)
class Replay:
    """Trials of every corner with their comparison, and the attacks on every claim (None: the joint is unstable)."""

    trials: Trials
    agreement: Agreement
    attacked: Challenge | None

    def __repr__(self) -> str:
        agrees = "contradicts" if self.contradictions else "agrees"
        drawn = f", {len(self.attacked.drawn.loads)} joints drawn" if self.attacked else ""
        return f"<Replay: {agrees}, {len(self.trials.trials)} trials{drawn}>"

    def _repr_html_(self) -> str:
        badge, tone = ("CONTRADICTS", "bad") if self.contradictions else ("AGREES", "good")
        rows = [("trials", self.agreement.summary(len(self.trials.trials)))]
        rows += [("attacks", self.attacked.summary())] if self.attacked else []
        return card("simulation", badge, tone, [*rows, *(("contradicts", text) for text in self.contradictions)])

    @property
    def contradictions(self) -> tuple[str, ...]:
        """What was simulated against what was proven, in words."""
        return self.agreement.contradictions + (self.attacked.contradictions if self.attacked else ())


def replay(
    content: dict[str, Any],
    checked: Verdict,
    file: str,
    progress: Callable[[str], None],
    *,
    count: int,
    seed: int,
    reality: Reality | None = None,
) -> Replay:
    """Simulate every load of a certificate whose format was already checked, and compare with its claims.

    Then attack the claims, with margins and levels of refutation as they are written: `count` loads are drawn with
    `seed`, 0 leaves the attacks out. `reality`: what the certificate leaves out, for information.

    Raises: MismatchError when the certificate does not say what the prover finds for its controller; InputError for a
    reality that cannot be.
    """
    spec = from_canonical(content["spec"], file)
    setting = setting_of(spec)
    coefficients = polynomials(content["controller"]["Q" if spec.controller.type == "dob" else "C"])
    C = realizable(setting, coefficients)
    claims = certify(setting, C)
    found = {(claim.id, claim.form): claim.status.value for claim in claims}
    for claim in content["claims"]:
        status = found.get((claim["id"], claim["form"]), claim["status"])
        if claim["status"] != status:
            raise MismatchError(
                f"{file}: {claim['id']} {claim['form']} is written as {claim['status']}, but is {status}"
            )
    if content["producer"].get("robimp") == version("robimp"):  # another version has other words for it
        _demand_texts(content, document(setting, coefficients, claims, bound=None, producer={}), file)
    if checked.exit_code != VERDICT_CODE[verdict(claims)]:
        raise MismatchError(f"{file}: {checked.message}")
    written = polynomials(content["controller"]["C"])
    compensator = (written.numerator, written.denominator)
    trials = verify(spec, compensator, progress=progress)
    agreement = compare(setting, C, claims, trials)
    if not count or not trials.stable:
        return Replay(trials, agreement, None)
    from .challenge import IDEAL, challenge  # loads the compiler

    said, told = claims_of(content), demanding(progress)
    attacked = challenge(
        spec, compensator, said, count=count, seed=seed, progress=told, coefficients=coefficients,
        reality=reality or IDEAL,
    )  # fmt: skip
    return Replay(trials, agreement, attacked)


def repeat_experiment(content: dict[str, Any], file: str, name: str) -> Experiment:
    """One of the paper's experiments (`fig9` … `fig12`, `hunting`) on a certificate's joint with its controller.

    Raises: InputError for an unknown name, and for the paper's figures on a joint that is not the paper's.
    """
    from .simulation.experiments import EXPERIMENTS, demand_papers_joint, notes  # loads the compiler

    if name not in EXPERIMENTS:
        raise InputError(f"--experiment: expected one of {', '.join(EXPERIMENTS)}; found {name}")
    spec, C = from_canonical(content["spec"], file), polynomials(content["controller"]["C"])
    if name != "hunting":  # which has no numbers of the paper but a friction, and a linear joint scales with it
        demand_papers_joint(spec)
    return replace(EXPERIMENTS[name](spec, (C.numerator, C.denominator)), notes=notes(spec, wishes=name != "hunting"))


def _demand_texts(written: dict[str, Any], expected: dict[str, Any], file: str) -> None:
    """The words of a certificate, which a person reads and the checker does not, are those of this version."""
    said = {(claim["id"], claim["form"]): claim for claim in expected["claims"]}
    for claim in written["claims"]:
        kind = claim["id"], claim["form"]
        for key in ("equation", "statement", "uncertainty"):
            if kind in said and claim[key] != said[kind][key]:
                raise MismatchError(f"{file}: {' '.join(kind)}: its {key} is not what was proven: {claim[key]}")
    for key in ("assumptions", "not_claimed"):
        if written[key] != expected[key]:
            raise MismatchError(f"{file}: {key}: not those of a certificate of this controller")
