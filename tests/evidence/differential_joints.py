"""Random joints: prover, independent checker and dense floats of the physics say the same of every claim."""

from __future__ import annotations

import copy
import json
import sys
import time
from collections.abc import Sequence
from fractions import Fraction

from judge import judge, required_level
from random_specs import Json, accepted, certified, extended_spec, parsed, random_spec, shipped
from tally import Tally, command
from tampering import sealed, written

from robimp.synthesis.check import Verdict, check_bytes
from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.recheck import DOUBTS

TITLE = "joints: prover, checker and dense floats of the physics"
FULL, SMALL, SLOW = 600, 12, 10
CHECK_SECONDS = 4.0


def expected_code(certificate: dict[str, object]) -> int:
    """The exit code the prover's statuses stand for."""
    claims: list[dict[str, object]] = certificate["claims"]  # type: ignore[assignment]
    statuses = {claim["status"] for claim in claims if claim["required"]}
    return 4 if "refuted" in statuses else 5 if "undecided" in statuses else 0


def doubted(verdict: Verdict) -> bool:
    """Whether the checker leaves a claim undecided that the prover has proven, be the whole refuted or not."""
    return any(status == "not verified" and any(d in said for d in DOUBTS) for *_, status, said in verdict.claims)


def too_timid(certificate: Json) -> list[str]:
    """Required claims the prover leaves undecided and the checker proves at the level asked for."""
    found = []
    for claim in certificate["claims"]:
        kind = (claim["id"], claim["form"])
        if claim["status"] == "undecided" and claim["required"] and claim["id"] != "bandwidth":
            changed = copy.deepcopy(certificate)
            own = next(c for c in changed["claims"] if (c["id"], c["form"]) == kind)
            own.update(status="proven", margin=str(Fraction(str(required_level(certificate["spec"], kind)))))
            verdict = check_bytes(written(sealed(changed)))
            found += [
                " ".join(kind) for id, form, status, _ in verdict.claims if (id, form, status) == (*kind, "proven")
            ]
    return found


def examine(seeds: Sequence[int]) -> Tally:
    found, features = Tally(), accepted()
    for seed in seeds:
        extended = bool(features) and seed % 3 == 2
        try:
            spec = parsed(extended_spec(seed, features) if extended else random_spec(seed))
        except InputError as error:
            found.count("specifications refused")
            found.expect("nominal" in str(error) or "table" in str(error), f"{seed}: refused: {error}")
            continue
        began = time.process_time()
        certificate = certified(spec)
        found.measure("seconds of one proof", seconds := time.process_time() - began)
        if seconds > SLOW:
            found.count(f"joints whose proof takes more than {SLOW} s: seed {seed}")
        began = time.process_time()
        verdict = check_bytes(json.dumps(certificate).encode(), time_limit=CHECK_SECONDS)
        if "time limit" in verdict.message or any("time limit" in message for *_, message in verdict.claims):
            found.count(f"joints not decided by the checker in {CHECK_SECONDS:g} s of each")  # never a wrong answer
            continue
        unsure = verdict.exit_code == ExitCode.UNDECIDED != expected_code(certificate)
        if unsure or doubted(verdict):  # then it is not shipped like this
            found.count("joints with a margin that the checker cannot confirm, conceded")
            certificate = shipped(spec)
            verdict = check_bytes(json.dumps(certificate).encode())
        found.measure("seconds of one check", time.process_time() - began)
        found.count("joints")
        found.count("  of these with sampling, ranges, tables, two-ports, noise or tolerance", int(extended))
        found.count(f"joints with exit code {verdict.exit_code}")
        found.expect(verdict.exit_code == expected_code(certificate), f"{seed}: checker: {verdict.message}")
        for id, form, status, message in verdict.claims:
            found.count(f"claims {status if status != 'not verified' else 'refuted'}")
            honest = status != "not verified" or "required, and" in message
            found.expect(honest, f"{seed}: {id} {form}: {message}")
        for name in too_timid(certificate):
            found.count(f"undecided by the prover, proven by the checker: seed {seed} {name}")
        judged, faults = judge(certificate, seed)
        found.count("claims judged by floats", judged)
        for fault in faults:
            found.fault(f"{seed}: floats: {fault}")
    return found


if __name__ == "__main__":
    sys.exit(command(TITLE, examine, FULL))
