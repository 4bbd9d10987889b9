"""Whatever the bytes: the readers of YAML, JSON and CSV answer, with the project's own errors, soon."""

from __future__ import annotations

import json
import re
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from tally import Tally, command
from tampering import sealed

from robimp.synthesis.check import check_bytes
from robimp.synthesis.errors import InputError, Location
from robimp.synthesis.spec import canonical, from_canonical, parse_spec
from robimp.synthesis.spec.table import read_table

TITLE = "fuzzing of the YAML, JSON and CSV readers"
FULL, SMALL = 100_000, 600
MOST_SECONDS = 5.0  # of the processor for one input
CHECK_SECONDS = 0.5  # allowed to the checker
ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
TROUBLE = [
    *"&*!{}[]:,-?|>\"'%#\t\n\r\x00\\/~.0123456789",
    *("&a ", "*a", "!!int ", "!!python/object:os.system ", ": ", "- ", "? ", "---\n", "...\n", "<<: ", "null", "true"),
    *("no", "on", "nan", ".inf", "-.inf", "NaN", "Infinity", "1e400", "1e-301", "0x1f", "0o7", "1_000", "1e3", "1/0"),
    *("±", "±100 %", "±5 %", "9" * 400, "1/" + "3" * 2500, "Hz", "kHz", "rad/s", "dB", "deg", "g·m²", "\\U00110000"),
    *("\ufeff", "\x85", "\u2028", "\ud800", "é", "٣", "𝟑", "[1, 2]", "{}", "[]", "[[", "{a: 1}", "inf", "2", "eq9"),
    *("sampling: {rate: 1 kHz, delay: 1 ms}", "noise: {gain: 30, above: 200 rad/s}", "tolerance: float32"),
    *(
        "table: {points: [[10, 0.1]], beyond: hold}",
        "actuator: {spring_stiffness: ±5 %}",
        "[0.2, 10]",
        "type: two-port",
    ),
]
CSV = [
    "omega [rad/s],bound\n0,0.1\n10,0.2\n100,1.5\n",
    "frequency [Hz],bound\n0.5,0.1\n10,0.2\n",
    "1,0.1\n2,0.2\n3,0.4\n",
    "\ufeffomega [rad/s],bound\r\n1,0.1\r\n2,0.2\r\n",
    "omega [rad/s];bound\n1;0.1\n",
]


@cache
def documents(kind: str) -> list[bytes]:
    """Documents to start from."""
    if kind == "csv":
        return [text.encode() for text in CSV]
    if kind == "yaml":
        found = [*(ROOT / "examples").glob("*.yaml"), *DATA.glob("specs/good.yaml"), *DATA.glob("golden/specs/*.yaml")]
    else:
        found = sorted(DATA.glob("golden/*.json"))
    return [path.read_bytes() for path in sorted(found)]


def _bytes(rng: Random, data: bytes) -> bytes:
    """Bits flipped, pieces cut, doubled, moved, or exchanged with those of another place."""
    for _ in range(rng.choice([1, 1, 2, 4, 16])):
        n = len(data)
        a, b = sorted((rng.randint(0, n), rng.randint(0, n)))
        b = min(b, a + rng.choice([1, 4, 40, 400]))
        data = rng.choice(
            [
                data[:a] + bytes([rng.randrange(256)]) + data[a + 1 :],
                data[:a] + data[b:],
                data[:b] + data[a:b] + data[b:],
                data[:a] + rng.randbytes(rng.randint(1, 4)) + data[a:],
                data[:a] + data[a:b][::-1] + data[b:],
                data[:a],
            ]
        )
    return data


def _tokens(rng: Random, data: bytes) -> bytes:
    """Words and signs of the grammar replaced by others, and by what is known to make trouble."""
    pieces = re.findall(r"[\w.+\-/±%²·]+|\s+|.", data.decode("utf-8"), re.DOTALL)
    for _ in range(rng.choice([1, 1, 1, 2, 5])):
        k = rng.randrange(len(pieces))
        pieces[k] = rng.choice(
            [rng.choice(TROUBLE), rng.choice(pieces), "", pieces[k] * 2, pieces[k] + rng.choice(TROUBLE)]
        )
    return "".join(pieces).encode("utf-8", "surrogatepass")


def _lines(rng: Random, data: bytes) -> bytes:
    """Lines exchanged, doubled, left out, or indented otherwise."""
    lines = data.split(b"\n")
    for _ in range(rng.choice([1, 2, 4])):
        a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
        how = rng.randrange(4)
        if how == 0:
            lines[a], lines[b] = lines[b], lines[a]
        elif how == 1:
            lines.insert(a, lines[b])
        elif how == 2 and len(lines) > 1:
            del lines[a]
        else:
            lines[a] = rng.choice([b" ", b"\t", b"    "]) + lines[a]
    return b"\n".join(lines)


def mutated(rng: Random, kind: str) -> bytes:
    data = rng.choice(documents(kind))
    if rng.random() < 0.02:
        return rng.randbytes(rng.randint(0, 300))
    return rng.choice([_bytes, _tokens, _tokens, _lines])(rng, data)


def _yaml(rng: Random, folder: Path) -> str:
    try:
        spec = parse_spec(mutated(rng, "yaml"), "<fuzz>")
    except InputError as error:
        if not str(error).startswith("<fuzz>") or "\n" in str(error) or len(str(error)) > 1000:
            raise AssertionError(f"not one line that says where: {error}") from error
        return "refused"
    if from_canonical(canonical(spec)) != spec:
        raise AssertionError("its canonical form is another specification")
    return "read"


def _json(rng: Random, folder: Path) -> str:
    data = mutated(rng, "json")
    verdict = check_bytes(data, time_limit=CHECK_SECONDS)
    if "\n" in verdict.message or verdict.exit_code not in (0, 2, 4, 5, 6):
        raise AssertionError(f"{verdict}")
    if verdict.exit_code == 0 and json.loads(data) not in [json.loads(d) for d in documents("json")]:
        raise AssertionError("accepted, and not one of those it was made from: the digest did not notice")
    return f"exit code {verdict.exit_code}"


def _edited(rng: Random, value: Any) -> Any:
    """A JSON value with something below it replaced by another value of the grammar."""
    if isinstance(value, dict) and value and rng.random() < 0.9:
        key = rng.choice(list(value))
        return {**value, key: _edited(rng, value[key])}
    if isinstance(value, list) and value and rng.random() < 0.9:
        k = rng.randrange(len(value))
        return [*value[:k], _edited(rng, value[k]), *value[k + 1 :]]
    simple = [
        None,
        True,
        0,
        -1,
        [],
        {},
        [[]],
        "",
        "0",
        "-1",
        "1/3",
        "inf",
        "10" * 400,
        "1/" + "7" * 1500,
        "none",
        "\ud800",
    ]
    return rng.choice([*simple, rng.choice(TROUBLE), value, [value] * 3])


def _sealed_json(rng: Random, folder: Path) -> str:
    """The digests are right: every field reaches its reader, and what is readable the proofs."""
    certificate = json.loads(rng.choice(documents("json")))
    key = rng.choice(["spec", "spec", "controller", "claims", "bandwidth"])
    certificate[key] = _edited(rng, certificate[key])
    try:
        data = json.dumps(sealed(certificate)).encode()
    except TypeError:  # no list of claims to count
        data = json.dumps(certificate).encode()
    verdict = check_bytes(data, time_limit=CHECK_SECONDS)
    if "\n" in verdict.message or verdict.exit_code not in (0, 2, 4, 5, 6):
        raise AssertionError(f"{verdict}")
    return f"exit code {verdict.exit_code}"


def _canonical(rng: Random, folder: Path) -> str:
    """A canonical specification out of a certificate, edited."""
    try:
        from_canonical(_edited(rng, json.loads(rng.choice(documents("json")))["spec"]))
    except InputError:
        return "refused"
    return "read"


def _csv(rng: Random, folder: Path) -> str:
    file = folder / "table.csv"
    file.write_bytes(mutated(rng, "csv"))
    try:
        read_table(file, Location(str(file), 1))
    except InputError as error:
        if "\n" in str(error):
            raise AssertionError(f"not one line: {error}") from error
        return "refused"
    return "read"


READERS: list[tuple[str, Callable[[Random, Path], str]]] = [
    ("YAML", _yaml),
    ("YAML", _yaml),
    ("JSON", _json),
    ("JSON", _json),
    ("JSON", _json),
    ("JSON, sealed again", _sealed_json),
    ("specification in JSON", _canonical),
    *([("CSV", _csv)] * 2),
]


def examine(seeds: Sequence[int]) -> Tally:
    found = Tally()
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            name, reader = READERS[seed % len(READERS)]
            began = time.process_time()
            try:
                answer = reader(Random(seed), Path(folder))
            except Exception as error:
                found.fault(f"{seed}: {name}: {type(error).__name__}: {str(error)[:200]}")
                answer = "an exception"
            seconds = time.process_time() - began
            found.measure(f"seconds, {name}", seconds)
            found.expect(seconds < MOST_SECONDS, f"{seed}: {name}: {seconds:.1f} s")
            found.count(f"{name}: {answer}")
            found.count("inputs")
    return found


if __name__ == "__main__":
    sys.exit(command(TITLE, examine, FULL))
