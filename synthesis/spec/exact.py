"""Number text to exact rational numbers and back: no float on the way."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction

MAX_DIGITS = 100  # of a decimal fraction; bounds the work every later station does with the number
MAX_EXPONENT = 300  # |value| within 1e±300, so that float(value) stays finite wherever floats are used
MAX_RATIO_DIGITS = 2000  # of p and of q in p/q, as written and in the canonical form

NUMBER = r"[+-]?(?:[0-9]+/[0-9]+|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
_NUMBER = re.compile(NUMBER)
_RATIO = re.compile(r"[+-]?[0-9]+(/[0-9]+)?")  # what canonical text looks like

# Text that some YAML reader takes for a number (or for another one) and that is refused here.
_MISREAD = tuple(
    (re.compile(pattern, re.IGNORECASE), advice)
    for pattern, advice in (
        (r"$", "it is empty: write a number"),
        (r"(null|~)$", "null is not a number: write the value, or remove the line where the key is optional"),
        (r"(y|n|yes|no|on|off|true|false)$", "it is a truth word: write a number"),
        (r"[+-]?\.?(nan|inf|infinity)$", "a number must be finite: write its value, or check where it comes from"),
        (r"[+-]?[0-9]+_[0-9_]*", "write the digits without underscores"),
        (r"[+-]?0[xob]", "write the number in decimal digits"),
        (r"[+-]?[0-9]+:[0-9]", "colons make it a base-60 number to some readers: write a decimal number"),
        (r"[+-]?[0-9]+,[0-9]", "write the decimal point as a point, and no thousands separator"),
        (r"[+-]?0[0-9]", "a leading zero makes it octal to some readers: remove it"),
    )
)


def misread(text: str) -> str | None:
    """Advice for text that only looks like a number; None: no objection."""
    return next((advice for pattern, advice in _MISREAD if pattern.match(text)), None)


def parse_number(text: str) -> Fraction:
    """The exact value of a decimal (`0.3`, `-2.5e-3`) or of a ratio of integers (`3/100`).

    Raises:
        ValueError: with advice for the person who wrote it.
    """
    advice = misread(text)
    if advice:
        raise ValueError(advice)
    if not _NUMBER.fullmatch(text):
        raise ValueError("write a number such as 0.3, 2.5e-3 or 3/100")
    return bounded(_ratio(text) if _RATIO.fullmatch(text) else _decimal(text))


def bounded(value: Fraction) -> Fraction:
    """The value itself, if every later station can afford it; also asked of what units and tolerances make of a number.

    Raises:
        ValueError: too large, too small, or too many digits.
    """
    limit = 10**MAX_EXPONENT
    if value and not Fraction(1, limit) <= abs(value) <= limit:
        raise ValueError(
            f"its magnitude in SI must lie between 1e-{MAX_EXPONENT} and 1e{MAX_EXPONENT}: check it and its unit"
        )
    if max(abs(value.numerator), value.denominator) >= 10**MAX_RATIO_DIGITS:
        raise ValueError(f"as a ratio of integers it has more than {MAX_RATIO_DIGITS} digits")
    return value


def number_text(value: Fraction) -> str:
    """Canonical text: `p` or `p/q` in lowest terms, q > 1."""
    return str(value)


def decimal_text(value: Fraction) -> str:
    """Six digits for a reader's eye; never read back."""
    with localcontext() as context:
        context.prec = 6
        return f"{Decimal(value.numerator) / Decimal(value.denominator):g}"


def polynomial_text(coefficients: Sequence[Fraction]) -> str:
    """`s^2 + 70.75 s + 2500` of coefficients in descending powers, six digits each; never read back."""
    text = ""
    for power, c in zip(range(len(coefficients) - 1, -1, -1), coefficients, strict=True):
        if c:
            s = {0: "", 1: "s"}.get(power, f"s^{power}")
            size = "" if abs(c) == 1 and power else f"{float(abs(c)):.6g}"
            sign = (" − " if c < 0 else " + ") if text else ("-" if c < 0 else "")
            text += sign + f"{size} {s}".strip()
    return text or "0"


def _ratio(text: str) -> Fraction:
    numerator, _, denominator = text.partition("/")
    if max(len(numerator.lstrip("+-")), len(denominator)) > MAX_RATIO_DIGITS:
        raise ValueError(f"at most {MAX_RATIO_DIGITS} digits above and below the stroke")
    if int(denominator or 1) == 0:
        raise ValueError("its denominator is zero")
    return Fraction(int(numerator), int(denominator or 1))


def _decimal(text: str) -> Fraction:
    mantissa, _, exponent = text.lower().partition("e")
    if len(mantissa) > MAX_DIGITS:
        raise ValueError(f"at most {MAX_DIGITS} digits")
    # Judged before any power of ten is built: 1e999999999 must cost nothing.
    if len(exponent) > 6 or abs(int(exponent or 0)) > MAX_EXPONENT:
        raise ValueError(f"its exponent must lie between -{MAX_EXPONENT} and {MAX_EXPONENT}: check it and its unit")
    return Fraction(text)
