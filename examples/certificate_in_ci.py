"""A certificate checked in continuous integration: what passes, and what stops a push.

examples/ci/ is what a repository keeps: the specification, its certificate, and the workflow that compares them at
every push. Expected: the exit codes, which are frozen.
"""

from __future__ import annotations

import json
from hashlib import sha256

from compared import FOLDER, Row, show

from robimp.synthesis import parse
from robimp.synthesis.check import canonical_json
from robimp.synthesis.judgement import judge
from robimp.synthesis.spec import canonical


def compare() -> list[Row]:
    """Exit codes of `robimp check gripper-certificate.json --spec gripper.yaml` after different pushes."""
    files = ("gripper.yaml", "gripper-certificate.json")
    spec, certificate = ((FOLDER / "ci" / name).read_text(encoding="utf-8") for name in files)
    damped = spec.replace("damping: 6,", "damping: 7,")
    return [
        ("as they are kept: proven, of this specification", exit_code(spec, certificate), 0),
        ("somebody changes the damping in the specification", exit_code(damped, certificate), 6),
        ("somebody changes a digit of the certificate", exit_code(spec, certificate.replace('"200"', '"201"', 1)), 2),
        ("somebody promises a lower peak, and seals it again", exit_code(spec, promised(certificate)), 4),
    ]


def exit_code(spec: str, certificate: str) -> int:
    """How the check ends."""
    return judge("certificate", certificate.encode(), canonical(parse(spec)), None, 60).exit_code


def promised(text: str) -> str:
    """The certificate with a peak of 1, digest and all."""
    certificate = json.loads(text)
    for claim in certificate["claims"]:
        if claim["id"] == "peak":
            claim["margin"], claim["refuted_at"] = "1", None
    body = {key: part for key, part in certificate.items() if key != "end"}
    certificate["end"]["body_sha256"] = sha256(canonical_json(body)).hexdigest()
    return json.dumps(certificate)


if __name__ == "__main__":
    show(compare())
