"""Transfer functions typeset in MathML, which a browser draws without scripts."""

from __future__ import annotations

from fractions import Fraction

from markupsafe import Markup

from ...spec.model import Polynomials
from .words import SHORT, rounded

WITHOUT_POWER = 5  # beyond 10^±5 a coefficient is written with a power of ten


def transfer(name: str, coefficients: Polynomials) -> Markup:
    """`name(s) = numerator/denominator`; with `≈` where a coefficient is rounded to six digits.

    name: a symbol, its index after an underscore; coefficients in descending powers of s.
    """
    symbol, _, index = name.partition("_")
    head = Markup("<mi>{}</mi>").format(symbol)
    if index:
        head = Markup("<msub>{}<mi>{}</mi></msub>").format(head, index)
    exact = all(Fraction(rounded(c, SHORT)) == c for c in (*coefficients.numerator, *coefficients.denominator))
    return Markup(
        '<math display="block"><mrow>{}<mo stretchy="false">(</mo><mi>s</mi><mo stretchy="false">)</mo><mo>{}</mo>'
        "<mfrac>{}{}</mfrac></mrow></math>"
    ).format(head, "=" if exact else "≈", _polynomial(coefficients.numerator), _polynomial(coefficients.denominator))


def _polynomial(coefficients: tuple[Fraction, ...]) -> Markup:
    terms: list[Markup] = []
    for power, c in zip(range(len(coefficients) - 1, -1, -1), coefficients, strict=True):
        if c:
            sign = "−" if c < 0 else "+"
            terms.append(Markup("<mo>{}</mo>").format(sign) if terms or c < 0 else Markup(""))
            terms.append(_term(abs(c), power))
    return Markup("<mrow>{}</mrow>").format(Markup("").join(terms or [Markup("<mn>0</mn>")]))


def _term(c: Fraction, power: int) -> Markup:
    s = Markup("")
    if power:
        s = Markup("<mi>s</mi>") if power == 1 else Markup("<msup><mi>s</mi><mn>{}</mn></msup>").format(power)
    return s if c == 1 and power else _number(c) + (Markup("<mspace width='0.15em'/>") + s if power else s)


def _number(c: Fraction) -> Markup:
    decimal = rounded(c, SHORT)
    power = decimal.adjusted()
    if abs(power) <= WITHOUT_POWER:
        return Markup("<mn>{}</mn>").format(f"{decimal:f}")
    return Markup("<mn>{}</mn><mo>·</mo><msup><mn>10</mn><mn>{}</mn></msup>").format(
        f"{decimal.scaleb(-power):f}", str(power).replace("-", "−")
    )
