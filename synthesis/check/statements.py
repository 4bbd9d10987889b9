"""What each claim says, as inequalities in x = ω² and facts: one function per claim id."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from .hurwitz import decays_faster
from .joint import Joint, Load, stiffness
from .outcome import Clock, MismatchError
from .polynomials import ONE, ZERO, OnAxis, Poly, X, norm2
from .positivity import Inequality


@dataclass(frozen=True)
class Fact:
    """A condition decided without subdivision; `at` is the frequency it speaks about: "0", "inf" or none."""

    holds: bool
    text: str
    at: str | None = None


@dataclass(frozen=True)
class Query:
    """A statement at value v, for the whole uncertainty or for one load; `ends`: its interval is 0..inf."""

    joint: Joint
    form: str
    v: Fraction
    load: Load | None
    ends: bool
    attenuation: Fraction
    clock: Clock

    @property
    def v2(self) -> Poly:
        """v² as a constant."""
        return Poly.of(self.v**2)

    def loads(self) -> tuple[Load, ...]:
        """Loads that decide a condition affine or convex in the load."""
        return self.joint.corners if self.load is None else (self.load,)


Parts = Iterator[Inequality | Fact]


def _below(terms: list[Poly], bound: Poly, strict: bool = True) -> Inequality:
    """`Σ √terms < √bound`, terms that vanish identically left out."""
    return Inequality(tuple((term,) for term in terms if term.c), (bound,), strict)


def _discs(q: Query) -> list[tuple[Poly, Poly]]:
    """Lumped radius from one source: pairs with `V² = pair[0]/pair[1]`, V the largest over the pairs."""
    joint = q.joint
    if joint.box is not None and joint.weight is not None:
        raise MismatchError(f"form {q.form} is for a box or a weight, not for both")
    if joint.weight is not None:
        return [joint.weight]
    loads = map(stiffness, q.loads())
    return [(norm2(joint.nominal - g), norm2(g)) for g in loads] if joint.box is not None else [(ZERO, ONE)]


Rows = tuple[Poly, ...]


def _ratios(q: Query) -> list[tuple[Rows, Rows]]:
    """`|ĝ − g|²` and `|g|²` for every load that can decide: corners (one row) and the edge (three rows in t)."""
    joint = q.joint
    if joint.box is None:
        return [((ZERO,), (ONE,))]
    found: list[tuple[Rows, Rows]] = [((norm2(joint.nominal - g),), (norm2(g),)) for g in map(stiffness, q.loads())]
    if joint.edge is not None and q.load is None:
        g0, g2 = (stiffness(load) for load in joint.edge)
        found.append((_segment(joint.nominal - g0, joint.nominal - g2), _segment(g0, g2)))
    return found


def _segment(p: Poly, q: Poly) -> Rows:
    """Bernstein rows in t of `|(1−t) p(jω) + t q(jω)|²`."""
    a, b = OnAxis.of(p), OnAxis.of(q)
    return a.norm2(), a.dot(b), b.norm2()


def _small_gain(q: Query, a: Poly, b: Poly, p: Poly = ZERO) -> Parts:
    """`|p| + v W |a| < |b|`, `W = W_b + W_w + W_b W_w`, `W_b = |ĝ−g|/|g|`, multiplied by |g| |d_w|."""
    a2, b2, p2 = q.v2 * norm2(a), norm2(b), norm2(p)
    n_w, d_w = q.joint.weight or (ZERO, ONE)
    for gap, size in _ratios(q):
        terms = [(size, d_w * p2), (gap, d_w * a2), (gap, n_w * a2), (size, n_w * a2)]
        products = [tuple(row * factor for row in rows) for rows, factor in terms]
        kept = tuple(term for term in products if any(row.c for row in term))
        yield Inequality(kept, tuple(row * d_w * b2 for row in size), strict=True)


def stability_free(q: Query) -> Parts:
    """All roots of the characteristic polynomial in free motion, nominal load, have Re s < −v."""
    yield Fact(decays_faster(q.joint.free(q.joint.nominal), q.v, q.clock), "a root does not decay at the stated rate")


def stability_locked(q: Query) -> Parts:
    """The same against a wall; a degree lost to `1 + HCF(∞) = 0` is a root at infinity."""
    yield Fact(decays_faster(q.joint.locked, q.v, q.clock), "a root does not decay at the stated rate")
    yield Fact(q.joint.locked.degree >= q.joint.E.degree, "1 + HCF vanishes at infinity")


def eq9(q: Query) -> Parts:
    """(9): `v W |U| < |(1−Q_i) ĝ + U|`, ideal actuator."""
    j = q.joint
    return _small_gain(q, j.U_n, j.E_i * j.nominal + j.U_n)


def eq12(q: Query) -> Parts:
    """Passivity (12) of the port, in one of three forms."""
    return {"paper": _paper, "disc": _disc, "structured": _structured}[q.form](q)


def _paper(q: Query) -> Parts:
    """`|s−m| + 2 r |(1−Q_i) ĝ| < |s+m|`, r = W'/(1−W'), W' = vW.

    By `|s+m| − |s−m| = 4 B_imp x/(|s+m| + |s−m|)`, x = ω², it is `W' (|h||s+m| + |h||s−m| + 2 B_imp x) < 2 B_imp x`
    with h = (1−Q_i) ĝ.
    """
    j, s = q.joint, Poly.of(0, 1)
    h2, D2 = norm2(j.E_i * j.nominal), norm2(j.D_i)
    bound = Poly.of(4 * j.damping**2) * X * X * D2
    for gap, size in _discs(q):
        radius = q.v2 * gap
        yield _below([gap * Poly.of(max(q.v, Fraction(1)) ** 2)], size)
        sums = [h2 * norm2(s + j.desired), h2 * norm2(s - j.desired), bound]
        yield _below([radius * term for term in sums], size * bound)


def _passive(q: Query, g: Poly, over: Poly, gap: Poly, size: Poly, strict: bool = False) -> Parts:
    """`Re[N/Ds] − ρ|E g/Ds| − Re[c E g/Ds] ≥ v`, N = E g + M, D = over, V² = gap/size < 1, times |D|²(size − gap)."""
    D, Y = OnAxis.of(over), OnAxis.of(q.joint.E * g)
    D2, rest = D.norm2(), size - gap
    margin = (OnAxis.of(q.joint.free(g)).cross(D) - Poly.of(q.v) * D2) * rest + gap * Y.cross(D)
    yield Inequality((), (margin,), strict, D2 * rest)
    if gap.c:
        yield _below([gap], size)
        yield _below([gap * size * Y.norm2() * D2], X * margin * margin, strict)


def _disc(q: Query) -> Parts:
    """Nominal load, every Δ with |Δ| ≤ V."""
    for gap, size in _discs(q):
        yield from _passive(q, q.joint.nominal, q.joint.locked, gap, size)
    yield from _port_ends(q)


def _structured(q: Query) -> Parts:
    """Every load of the box (corners: the left side is concave in g), the weight on top."""
    gap, size = q.joint.weight or (ZERO, ONE)
    for load in q.loads():
        yield from _passive(q, stiffness(load), q.joint.locked, gap, size)
    yield from _port_ends(q)


def _port_ends(q: Query) -> Parts:
    """On 0..inf: Z(0) finite and ≥ 0, and Z/s² → a limit ≥ 0 at infinity, so Z/s has passive poles there."""
    if not q.ends:
        return
    D = q.joint.locked.c
    low = next((k for k, a in enumerate(D) if a), 0)
    for load in q.loads():
        N = q.joint.free(stiffness(load)).c
        at_zero = D != () and not any(N[:low]) and (N[low] if low < len(N) else 0) * D[low] >= 0
        yield Fact(at_zero, "Z(0) is not finite and >= 0", "0")
        top = len(D) + 1
        at_inf = D != () and len(N) <= top + 1 and (N[top] if top < len(N) else 0) * D[-1] >= 0
        yield Fact(at_inf, "Z/s^2 has no limit >= 0 at infinity", "inf")


def eq18(q: Query) -> Parts:
    """(18) with actuator: `T = H U/(ĝ+Z_a)` frozen, `(1−Q_i) Z_a/ĝ + H U/ĝ` physical, `D0 = 1 − Q_i + T`."""
    j = q.joint
    form, coupling = q.form.split("/")
    D0 = j.free(j.nominal)
    if coupling == "frozen":
        T, D = j.n_H * j.U_n, j.D_i * (j.d * j.nominal + j.n_Z)
    else:
        T, D = j.M, j.D_i * j.d * j.nominal
    if form == "paper":
        return _small_gain(q, T, D, D0 - D)
    if form == "lumped":
        return _small_gain(q, T * j.nominal, j.desired * D, D0 * j.nominal - j.desired * D)
    return _small_gain(q, T, D0)


def sensitivity(q: Query) -> Parts:
    """`|1 − Q̃| ≤ v`, or the attenuation in the bandwidth claim, where v is the end of the interval."""
    level = q.attenuation if q.form == "attenuation" else q.v
    yield _below([norm2(q.joint.E)], Poly.of(level**2) * norm2(q.joint.locked), strict=False)


def rendering(q: Query) -> Parts:
    """`|Z(g) − m − c(1−Q̃)g| + ρ|(1−Q̃)g| ≤ v|m|` for every load (corners: convex in g), times |locked|(size − gap)."""
    j = q.joint
    gap, size = j.weight or (ZERO, ONE)
    rest = size - gap
    if gap.c:
        yield _below([gap], size)
    for load in q.loads():
        g = stiffness(load)
        error, Y = OnAxis.of(j.free(g) - j.desired * j.locked), OnAxis.of(j.E * g)
        a = OnAxis(error.re * rest + gap * Y.re, error.im * rest + gap * Y.im)
        bound = q.v2 * norm2(j.desired) * norm2(j.locked) * rest * rest
        yield _below([a.norm2(), gap * size * Y.norm2()], bound, strict=False)


def friction(q: Query) -> Parts:
    """`Re[(L R m + Z_0(g))/s] − ρ|g/s| − Re[c g/s] ≥ v`, every load: `L R m + Z_0 = (E g + M)/E`; strict at v = 0."""
    gap, size = q.joint.weight or (ZERO, ONE)
    for load in q.loads():
        yield from _passive(q, stiffness(load), q.joint.E, gap, size, strict=q.v == 0)


STATEMENTS: dict[str, tuple[tuple[str, ...], Callable[[Query], Parts]]] = {
    "stability-free": (("hurwitz",), stability_free),
    "stability-locked": (("hurwitz",), stability_locked),
    "eq9": (("printed",), eq9),
    "eq12": (("paper", "disc", "structured"), eq12),
    "eq18": (tuple(f"{f}/{c}" for f in ("paper", "lumped", "half-plane") for c in ("frozen", "physical")), eq18),
    "bandwidth": (("attenuation",), sensitivity),
    "rendering": (("every-load",), rendering),
    "peak": (("sensitivity",), sensitivity),
    "friction": (("strictly-positive-real",), friction),
}
