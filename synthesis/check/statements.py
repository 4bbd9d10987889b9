"""What each claim says at a value v, for the whole uncertainty or one load: written once, for polynomials and cells."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial, reduce
from itertools import product
from operator import mul

from .cells import Cell
from .joint import Joint, Real, S, Value
from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, X, norm2, on_axis
from .positivity import Inequality

Load = Poly | None  # dynamic stiffness of the one load of a witness; None: every load of the uncertainty
Parts = Iterator[Inequality]  # to be proven


def _ratios(j: Joint, load: Load, edge: bool = False) -> list[tuple[Real, Real]]:
    """`|ĝ − g|²` and `|g|²` for every load that can decide; on the edge where it is a parameter."""
    loads = [*j.loads(load), *(j.edge if edge and load is None else [])]
    return [(norm2(j.nominal - g), norm2(g)) for g in loads] if j.box else [(ZERO, ONE)]


def _discs(j: Joint, load: Load) -> list[tuple[Real, Real]]:
    """Lumped radius from a box or from discs: pairs with `V² = pair[0]/pair[1]`, V the largest over the pairs."""
    disc = any(j.spec["uncertainty"][key] for key in ("weight", "table"))
    demand(not (j.box and disc), "this form is for a box or for discs, not for both", MISMATCH)
    return _ratios(j, load) if j.box else [j.disc]


def _small_gain(j: Joint, v: Fraction, load: Load, a: Value, b: Value, p: Value = ZERO) -> Parts:
    """`|p| + v W |a| < |b|`, 1 + W = Π (1 + W_i), W_i² = gap/size, W_b = |ĝ−g|/|g|, multiplied by the sizes."""
    a2, b2, p2 = Poly.of(v**2) * norm2(a), norm2(b), norm2(p)
    for ratio in _ratios(j, load, edge=True):
        sources = [ratio, *j.sources]
        whole = reduce(mul, [size for _, size in sources])
        terms = [p2 * whole]
        for chosen in product((0, 1), repeat=len(sources)):  # gaps of these, sizes of the others
            factors = [source[1 - c] for source, c in zip(sources, chosen, strict=True)]
            terms += [reduce(mul, factors, a2)] if any(chosen) else []
        yield Inequality(terms, b2 * whole)


def eq12_paper(j: Joint, v: Fraction, load: Load) -> Parts:
    """(12): `|s−m| + 2 r |(1−Q_i) ĝ| < |s+m|`, r = W'/(1−W'), W' = vW.

    With h = (1−Q_i) ĝ and `|s+m|² − |s−m|² = 4 Re(s m̄) = 4 B x` it is `W' (|h||s+m| + |h||s−m| + 2 B x) < 2 B x`."""
    m, h2, D2 = j.desired, norm2(j.E_i * j.nominal), norm2(j.D_i)
    room = Poly.of(2) * X * on_axis(m, ONE)[1]
    for gap, size in _discs(j, load):
        yield Inequality([Poly.of(max(v, Fraction(1)) ** 2) * gap], size)
        radius, sums = Poly.of(v**2) * gap, [h2 * norm2(m + S), h2 * norm2(m - S), room * room * D2]
        yield Inequality([radius * term for term in sums], room * room * D2 * size)


def passivity(form: str, j: Joint, v: Fraction, load: Load) -> Parts:
    """`Re[N/Ds] − ρ|E g/Ds| − Re[c E g/Ds] ≥ v`, N = E g + M, V² = gap/size < 1, times |D|²(size − gap).
    D = locked: the port Z/s. D = E: `(L R m + Z_0)/s`, friction, strict at v = 0. Concave in g: the corners decide."""
    D, strict = (j.E, v == 0) if form == "friction" else (j.locked, False)
    pairs = [(j.nominal, disc) for disc in _discs(j, load)] if form == "disc" else [(g, j.disc) for g in j.loads(load)]
    D2 = norm2(D)
    for g, (gap, size) in pairs:
        Y, rest = j.E * g, size - gap
        margin = (on_axis(Y + j.M, D)[1] - Poly.of(v) * D2) * rest + gap * on_axis(Y, D)[1]
        yield Inequality([], margin, strict, D2 * rest)
        if gap:
            yield Inequality([gap], size)
            yield Inequality([gap * size * norm2(Y) * D2], X * margin * margin, strict)


def port_ends(friction: bool, j: Joint, cell: Cell, load: Load) -> Iterator[Inequality | str]:
    """Where Re(Z/s) is silent about the pole of Z/s: Z(0) ≥ 0 and lim Z/s² ≥ 0; friction: N(g)/N(ĝ) > 0 there.
    A disc makes the value A − (A−B)e, B that of E g, over all real e in [−V, V]: A ≥ 0 and (A−B)² V² ≤ A².
    The cell is the point ω = 0 or ∞."""
    gap, size = (cell.real(part) for part in j.disc)
    V2 = (gap * size.inverse()).at(0)
    below = cell.axis(j.free(j.nominal) if friction else j.locked * (S * S if cell.far else ONE)).inverse()
    for g in j.loads(load):
        A, B = cell.axis(j.free(g)) * below, cell.axis(j.E * g) * below
        if A.bounded() and B.bounded():
            a = A.p.at(0)
            yield Inequality([], a, friction)
            if j.sources:
                yield Inequality([V2 * (a - B.p.at(0)) * (a - B.p.at(0))], a * a, friction)
        else:
            yield f"{'Z at infinity' if cell.far else 'Z(0)'} is not finite and {'>' if friction else '>='} 0"


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


STATEMENTS: dict[tuple[str, str], Callable[[Joint, Fraction, Load], Parts]] = {
    ("bandwidth", "attenuation"): partial(sensitivity, "bandwidth"),
    ("peak", "sensitivity"): partial(sensitivity, "peak"),
    ("noise", "command"): partial(sensitivity, "noise"),
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
