"""What each claim says at a value v, for the whole uncertainty or one load: written once, for polynomials and cells."""

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import product

from .joint import Joint, Parts, Real, S, Value
from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, X, norm2, on_axis
from .positivity import Inequality

Load = Poly | None  # dynamic stiffness of the one load of a witness; None: every load of the uncertainty
Limit = Callable[[Callable[[Joint], tuple[Poly, Poly]], Poly], Real]  # of a part over a power of s; None: infinite
EDGE = "edge"  # of the box of loads: where on it is a parameter
LOADED = "impedance", "actuator"  # sections of parameters that a statement depends on


def _discs(j: Joint, load: Load) -> list[tuple[Real, Real]]:
    """Lumped radius from a box or from discs: pairs with `V² = pair[0]/pair[1]`, V the largest over the pairs."""
    discs = any(j.spec["uncertainty"][key] for key in ("weight", "table"))
    demand(not (j.box and discs), "this form is for a box or for discs, not for both", MISMATCH)
    return j.ratios(load) if j.box else [j.disc]


def _small_gain(j: Joint, v: Fraction, load: Load, a: Value, b: Value, p: Value = ZERO) -> Parts:
    """`|p| + v W |a| < |b|`, 1 + W = (1 + W_b)(1 + V), W_b = |ĝ−g|/|g|, multiplied by |g|, or by V's denominator."""
    a2, b2, p2 = Poly.of(v**2) * norm2(a), norm2(b), norm2(p)
    if j.box and j.disc[0]:
        yield from j.both(a2, b2, p2, load)
        return
    for gap, size in j.ratios(load, edge=True) if j.box else [j.disc]:
        yield Inequality([p2 * size, a2 * gap], b2 * size)


def eq12_paper(j: Joint, v: Fraction, load: Load) -> Parts:
    """(12): `|s−m| + 2 r |(1−Q_i) ĝ| < |s+m|`, r = W'/(1−W'), W' = vW.

    With h = (1−Q_i) ĝ and `|s+m|² − |s−m|² = 4 Re(s m̄) = 4 B x` it is `W' (|h||s+m| + |h||s−m| + 2 B x) < 2 B x`."""
    m, h2, D2 = j.desired, norm2(j.E_i * j.nominal), norm2(j.D_i)
    room = Poly.of(2) * X * on_axis(m, ONE)[1]
    for gap, size in _discs(j, load):
        yield Inequality([Poly.of(max(v, Fraction(1)) ** 2) * gap], size)
        yield from j.weighed(Poly.of(v**2) * gap, h2 * norm2(m + S), h2 * norm2(m - S), room * room * D2, size)


def passivity(form: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """`Re[N/Ds] − ρ|E g/Ds| − Re[c E g/Ds] ≥ v`, N = E g + M = D g + L, V² = gap/size < 1, times |D|²(size − gap).
    D = locked: the port Z/s. D = E: `(L R m + Z_0)/s`, friction, strict at v = 0. Concave in g: the corners decide."""
    D, strict = (j.E, v == 0) if form == "friction" else (j.locked, False)
    pairs = [(j.nominal, disc) for disc in _discs(j, load)] if form == "disc" else [(g, j.disc) for g in j.loads(load)]
    D2 = norm2(D)
    for g, (gap, size) in pairs:
        L, room = j.M if form == "friction" else j.M - j.rest * g, size - gap
        margin = ((on_axis(g, ONE)[1] - Poly.of(v)) * D2 + on_axis(L, D)[1]) * room
        if gap:
            Y = j.E * g
            margin = margin + gap * on_axis(Y, D)[1]
        yield Inequality([], margin, strict, D2 * room)
        if gap:
            yield Inequality([gap], size)
            yield Inequality([gap * size * norm2(Y) * D2], X * margin * margin, strict)


def port_ends(name: str, far: bool, j: Joint, limit: Limit, V2: Real, load: Load) -> Parts:
    """Where Re(Z/s) is silent about the pole of Z/s: Z(0) ≥ 0 and lim Z/s² ≥ 0; friction: N(g)/N(ĝ) > 0 there.
    A disc makes the value A − M e, A that of E g + M, over all real e in [−V, V]: A ≥ 0 and M² V² ≤ A².
    The limits at ω = 0 or ∞ are over the nominal's denominator, the function called `name`; c is that of this one."""
    strict = name == "stability-free"
    power = S * S if far and not strict else ONE
    c = limit(partial(Joint.loop, name=name, g=j.nominal), ONE)
    for g in j.loads(load):
        A, M = (limit(partial(Joint.loop, name="stability-free", g=at), power) for at in (g, ZERO))
        A, M, over = (-ONE, ZERO, ONE) if A is None or M is None or c is None else (A, M, c)
        yield Inequality([], over * over)
        yield Inequality([], A * over, strict)
        if V2:
            yield Inequality([V2 * M * M], A * A, strict)


def eq18(form: str, actuator: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """(18): `T = H U/(ĝ+Z_a)` frozen, `(1−Q_i) Z_a/ĝ + H U/ĝ` physical, `D0 = 1 − Q_i + T`; (9) if H = 1, Z_a = 0."""
    D0, T, D = j.free(j.nominal), j.M, j.D_i * j.d * j.nominal
    if actuator == "ideal":
        D0, T = j.E_i * j.nominal + j.U_n, j.U_n
    if actuator == "frozen":
        T, D = j.driven, j.D_i * (j.d * j.nominal + j.n_Z)
    if form == "paper":
        return _small_gain(j, v, load, T, D, D0 - D)
    if form == "lumped":
        return _small_gain(j, v, load, T * j.nominal, j.desired * D, D0 * j.nominal - j.desired * D)
    return _small_gain(j, v, load, T, D0)


def sensitivity(name: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """`|1 − Q̃| ≤ v`, or the attenuation in the bandwidth claim, where v is its interval's end; noise: |CF/(1+HCF)|."""
    level = j.spec["objective"]["attenuation"] if name == "bandwidth" else v
    yield Inequality([norm2(j.command if name == "noise" else j.E)], Poly.of(level**2) * norm2(j.locked), strict=False)


def rendering(j: Joint, v: Fraction, load: Load) -> Parts:
    """`|Z(g) − m − c(1−Q̃)g| + ρ|(1−Q̃)g| ≤ v|m|` for every load (corners: convex in g), times |locked|(size − gap)."""
    gap, size = j.disc
    rest = size - gap
    yield Inequality([gap], size)
    for g in j.loads(load):
        error, Y = j.free(g) - j.desired * j.locked, j.E * g
        cross = Poly.of(2) * rest * gap * on_axis(error, Y)[0]
        left2 = rest * rest * norm2(error) + cross + gap * gap * norm2(Y)
        bound = Poly.of(v**2) * norm2(j.desired) * norm2(j.locked) * rest * rest
        yield Inequality([left2, gap * size * norm2(Y)], bound, strict=False)


# What is stated for an ideal actuator means something if the nominal joint is stable behind one, in this sense.
IDEAL = {("eq9", "printed"): "stability-free", ("eq12", "paper"): "stability-locked"}
EQ18 = "paper", "lumped", "half-plane"
DRIVEN = *LOADED, EDGE
Statement = Callable[[Joint, Fraction, Load], Parts]
STATEMENTS: dict[tuple[str, str], tuple[Statement, tuple[str, ...]]] = {  # and the parameters it depends on
    ("bandwidth", "attenuation"): (partial(sensitivity, "bandwidth"), ("actuator",)),
    ("peak", "sensitivity"): (partial(sensitivity, "peak"), ("actuator",)),
    ("noise", "command"): (partial(sensitivity, "noise"), ("actuator",)),
    ("rendering", "every-load"): (rendering, LOADED),
    ("friction", "strictly-positive-real"): (partial(passivity, "friction"), LOADED),
    ("eq9", "printed"): (partial(eq18, "half-plane", "ideal"), ("impedance", EDGE)),
    ("eq12", "paper"): (eq12_paper, ("impedance",)),
    **{("eq12", form): (partial(passivity, form), LOADED) for form in ("disc", "structured")},
    **{("eq18", f"{f}/{c}"): (partial(eq18, f, c), DRIVEN) for c, f in product(("frozen", "physical"), EQ18)},
}
