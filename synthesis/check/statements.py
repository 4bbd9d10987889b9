"""What each claim says at a value v, for the whole uncertainty or one load: inequalities in x = ω², and facts."""

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from math import inf

from .joint import Joint
from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, X, decays_faster, norm2, on_axis
from .positivity import Inequality

Load = Poly | None  # dynamic stiffness of the one load of a witness; None: every load of the uncertainty
Parts = Iterator[Inequality | str]  # to be proven; or a condition that fails, decided without subdivision


def _ratios(j: Joint, load: Load) -> list[tuple[Poly, Poly]]:
    """`|ĝ − g|²` and `|g|²` for every load that can decide but those on the edge."""
    return [(norm2(j.nominal - g), norm2(g)) for g in j.loads(load)] if j.box else [(ZERO, ONE)]


def _discs(j: Joint, load: Load) -> list[tuple[Poly, Poly]]:
    """Lumped radius from one source: pairs with `V² = pair[0]/pair[1]`, V the largest over the pairs."""
    demand(None in j.spec["uncertainty"].values(), "this form is for a box or a weight, not for both", MISMATCH)
    return _ratios(j, load) if j.box else [j.weight]


def _small_gain(j: Joint, v: Fraction, load: Load, a: Poly, b: Poly, p: Poly = ZERO) -> Parts:
    """`|p| + v W |a| < |b|`, `W = W_b + W_w + W_b W_w`, `W_b = |ĝ−g|/|g|`, multiplied by |g| |d_w|."""
    a2, b2, p2 = Poly.of(v**2) * norm2(a), norm2(b), norm2(p)
    n_w, d_w = j.weight
    pairs: list[tuple[list[Poly], ...]] = [([gap], [size]) for gap, size in _ratios(j, load)]
    if j.edge and load is None:  # rows in t of |(1−t) g + t h|²
        g, h = j.edge
        ends = (j.nominal - g, j.nominal - h), (g, h)
        pairs.append(tuple([norm2(p), on_axis(p, q)[0], norm2(q)] for p, q in ends))
    for gap, size in pairs:
        terms = [(size, d_w * p2), (gap, d_w * a2), (gap, n_w * a2), (size, n_w * a2)]
        products = [[row * factor for row in rows] for rows, factor in terms]
        yield Inequality(products, [row * d_w * b2 for row in size])


def stability(end: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """All roots of the characteristic polynomial, free with the nominal load or against a wall, have Re s < −v."""
    p = j.locked if end == "locked" else j.free(j.nominal)
    if not decays_faster(p, v, j.deadline):
        yield "a root does not decay at the stated rate"
    if end == "locked" and len(j.locked.c) < len(j.E.c):  # a lost degree is a root at infinity
        yield "1 + HCF vanishes at infinity"


def eq12_paper(j: Joint, v: Fraction, load: Load) -> Parts:
    """(12): `|s−m| + 2 r |(1−Q_i) ĝ| < |s+m|`, r = W'/(1−W'), W' = vW.

    With h = (1−Q_i) ĝ and `|s+m|² − |s−m|² = 4 B_imp x` it is `W' (|h||s+m| + |h||s−m| + 2 B_imp x) < 2 B_imp x`.
    """
    s, h2 = Poly.of(0, 1), norm2(j.E_i * j.nominal)
    bound = Poly.of(4 * j.spec["impedance"]["damping"] ** 2) * X * X * norm2(j.D_i)
    for gap, size in _discs(j, load):
        yield Inequality([[Poly.of(max(v, Fraction(1)) ** 2) * gap]], [size])
        radius, sums = Poly.of(v**2) * gap, [h2 * norm2(s + j.desired), h2 * norm2(s - j.desired), bound]
        yield Inequality([[radius * term] for term in sums], [size * bound])


def passivity(form: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """`Re[N/Ds] − ρ|E g/Ds| − Re[c E g/Ds] ≥ v`, N = E g + M, V² = gap/size < 1, times |D|²(size − gap).
    D = locked: the port Z/s. D = E: `(L R m + Z_0)/s`, friction, strict at v = 0. Concave in g: the corners decide."""
    D, strict = (j.E, v == 0) if form == "friction" else (j.locked, False)
    pairs = (
        [(j.nominal, disc) for disc in _discs(j, load)] if form == "disc" else [(g, j.weight) for g in j.loads(load)]
    )
    for g, (gap, size) in pairs:
        Y, D2, rest = j.E * g, norm2(D), size - gap
        margin = (on_axis(j.free(g), D)[1] - Poly.of(v) * D2) * rest + gap * on_axis(Y, D)[1]
        yield Inequality([], [margin], strict, D2 * rest)
        if gap.c:
            yield Inequality([[gap]], [size])
            yield Inequality([[gap * size * norm2(Y) * D2]], [X * margin * margin], strict)


def port_ends(friction: bool, j: Joint, load: Load, ends: Sequence[Fraction | float]) -> Parts:
    """Where Re(Z/s) is silent about the pole of Z/s: Z(0) ≥ 0 and lim Z/s² ≥ 0; friction: N(g)/N(ĝ) > 0 there.
    A weight makes the value A − (A−B)e, B that of E g, over all real e in [−V, V]: A ≥ 0 and A² ≥ (A−B)² V²."""
    gap, size = j.weight
    for g in j.loads(load):
        N, Y, D, shift = j.free(g), j.E * g, j.free(j.nominal) if friction else j.locked, 0 if friction else 2
        top = max(len(N.c), len(D.c) + shift) - 1
        low = next((k for k in range(top + 1) if N.at(k) or D.at(k)), 0)
        for at, n, d, w in ((Fraction(0), low, low, 0), (inf, top, top - shift, len(size.c) - 1)):
            a, b, reference = N.at(n), Y.at(n), D.at(d)
            least = min(a * reference, a * a * size.at(w) - (a - b) ** 2 * gap.at(w))
            if at in ends and (reference == 0 or least < 0 or (friction and least == 0)):
                yield f"{'Z(0)' if at == 0 else 'Z at infinity'} is not finite and {'>' if friction else '>='} 0"


def eq18(form: str, actuator: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """(18): `T = H U/(ĝ+Z_a)` frozen, `(1−Q_i) Z_a/ĝ + H U/ĝ` physical, `D0 = 1 − Q_i + T`; (9) if H = 1, Z_a = 0."""
    D0, T, D = j.free(j.nominal), j.M, j.D_i * j.d * j.nominal
    if actuator == "ideal":
        D0, T = j.E_i * j.nominal + j.U_n, j.U_n
    if actuator == "frozen":
        T, D = j.n_H * j.U_n, j.D_i * (j.d * j.nominal + j.n_Z)
    if form == "paper":
        return _small_gain(j, v, load, T, D, D0 - D)
    if form == "lumped":
        return _small_gain(j, v, load, T * j.nominal, j.desired * D, D0 * j.nominal - j.desired * D)
    return _small_gain(j, v, load, T, D0)


def sensitivity(name: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """`|1 − Q̃| ≤ v`, or the attenuation in the bandwidth claim, where v is the end of the interval."""
    level = j.spec["objective"]["attenuation"] if name == "bandwidth" else v
    yield Inequality([[norm2(j.E)]], [Poly.of(level**2) * norm2(j.locked)], strict=False)


def rendering(j: Joint, v: Fraction, load: Load) -> Parts:
    """`|Z(g) − m − c(1−Q̃)g| + ρ|(1−Q̃)g| ≤ v|m|` for every load (corners: convex in g), times |locked|(size − gap)."""
    gap, size = j.weight
    rest = size - gap
    yield Inequality([[gap]], [size])
    for g in j.loads(load):
        error, Y = j.free(g) - j.desired * j.locked, j.E * g
        cross = Poly.of(2) * rest * gap * on_axis(error, Y)[0]
        left2 = rest * rest * norm2(error) + cross + gap * gap * norm2(Y)
        bound = Poly.of(v**2) * norm2(j.desired) * norm2(j.locked) * rest * rest
        yield Inequality([[left2], [gap * size * norm2(Y)]], [bound], strict=False)


STATEMENTS: dict[tuple[str, str], Callable[[Joint, Fraction, Load], Parts]] = {
    ("stability-free", "hurwitz"): partial(stability, "free"),
    ("stability-locked", "hurwitz"): partial(stability, "locked"),
    ("bandwidth", "attenuation"): partial(sensitivity, "bandwidth"),
    ("peak", "sensitivity"): partial(sensitivity, "peak"),
    ("rendering", "every-load"): rendering,
    ("friction", "strictly-positive-real"): partial(passivity, "friction"),
    ("eq9", "printed"): partial(eq18, "half-plane", "ideal"),
    ("eq12", "paper"): eq12_paper,
    **{("eq12", form): partial(passivity, form) for form in ("disc", "structured")},
    **{
        ("eq18", f"{f}/{c}"): partial(eq18, f, c)
        for c in ("frozen", "physical")
        for f in ("paper", "lumped", "half-plane")
    },
}
