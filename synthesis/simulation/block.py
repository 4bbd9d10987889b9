"""Linear blocks whose ports are named by the signals of the joint, and their interconnection.

Every physical law is one block; wiring is by name: an output feeds every input of the same name. The same algebra
serves continuous (`x' = A x + B u`) and sampled (`x⁺ = A x + B u`) time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

from ..errors import InputError, RobimpError

Matrix = NDArray[np.floating[Any]]

WELL_POSED = 1e-9  # smallest |1 − loop gain| at infinite frequency that floats can still resolve


@dataclass(frozen=True, eq=False)
class Block:
    """`x' = A x + B u`, `y = C x + D u`: u and y are the signals named by `inputs` and `outputs`."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix

    def row(self, signal: str) -> Matrix:
        """Row of C that reads `signal` from the state, (n,)."""
        return np.asarray(self.C[self.outputs.index(signal)])


def combination(output: str, **weights: Fraction | int) -> Block:
    """Static law `output = Σ weight · signal`; without weights, zero.

    Raises: InputError when a weight leaves the range of floats.
    """
    n = len(weights)
    gains = np.array([_number(output, weight) for weight in weights.values()]).reshape(1, n)
    return Block(tuple(weights), (output,), np.zeros((0, 0)), np.zeros((0, n)), np.zeros((1, 0)), gains)


def integrator(output: str, rate: str) -> Block:
    """`output' = rate`."""
    one = np.ones((1, 1))
    return Block((rate,), (output,), 0 * one, one, one, 0 * one)


def low_pass(output: str, signal: str, corner: Fraction | None) -> Block:
    """First-order filter `1/(1 + s/corner)`, corner [rad/s]; None: unfiltered."""
    return transfer(output, signal, [Fraction(1)], [Fraction(1)] if corner is None else [1 / corner, Fraction(1)])


def transfer(output: str, signal: str, numerator: Sequence[Fraction], denominator: Sequence[Fraction]) -> Block:
    """Proper rational law `output = numerator/denominator · signal`, coefficients in descending powers of s [rad/s].

    Companion form in a time scale near the geometric mean of the poles, balanced; common factors are not cancelled.

    Raises: InputError when the denominator is zero, the law is improper, or a coefficient leaves the range of floats.
    """
    a = leading(denominator)
    if len(a) == 1:
        return combination(output, **{signal: _over(output, numerator, a)[0] / a[0]})
    rate, poles, rows = _companion(output, [numerator], a)
    order, (zeros, feedthrough) = len(poles), rows[0]
    A = np.eye(order, k=-1)
    A[0] = -poles
    return balanced(
        Block((signal,), (output,), rate * A, rate * np.eye(order, 1), zeros[None, :], np.array([[feedthrough]]))
    )


def transfers(output: str, numerators: dict[str, Sequence[Fraction]], denominator: Sequence[Fraction]) -> Block:
    """`output = Σ numerator · signal / denominator` with one state for all: the transpose of `transfer`'s form.

    Raises: as `transfer`.
    """
    a, signals = leading(denominator), tuple(numerators)
    if len(a) == 1:
        return combination(output, **{name: _over(output, b, a)[0] / a[0] for name, b in numerators.items()})
    rate, poles, rows = _companion(output, list(numerators.values()), a)
    A = np.eye(len(poles), k=1)
    A[:, 0] = -poles
    B, D = np.column_stack([zeros for zeros, _ in rows]), np.array([[feedthrough for _, feedthrough in rows]])
    return balanced(Block(signals, (output,), rate * A, B, rate * np.eye(1, len(poles)), D))


def _over(law: str, numerator: Sequence[Fraction], a: Sequence[Fraction]) -> list[Fraction]:
    """The numerator with as many coefficients as the denominator `a`."""
    b = leading(numerator)
    if not a or len(b) > len(a):
        degrees = f"degree {len(b) - 1} over degree {len(a) - 1}"
        raise InputError(f"{law}: {degrees} is not a proper rational function of s")
    return [Fraction(0)] * (len(a) - len(b)) + b


def _companion(
    law: str, numerators: Sequence[Sequence[Fraction]], a: Sequence[Fraction]
) -> tuple[float, Matrix, list[tuple[Matrix, float]]]:
    """Time scale, monic denominator in it, and the rest and feedthrough of each numerator."""
    over = [[value / a[0] for value in _over(law, b, a)] for b in numerators]
    monic, powers = [value / a[0] for value in a] if a else [], range(1, len(a))
    scale = _time_scale(monic)
    poles = np.array([_number(law, monic[i] / scale**i) for i in powers])
    rest = [np.array([_number(law, (b[i] - b[0] * monic[i]) / scale**i) for i in powers]) for b in over]
    return _number(law, scale), poles, [(zeros, _number(law, b[0])) for zeros, b in zip(rest, over, strict=True)]


def balanced(block: Block) -> Block:
    """The same law in state units that make rows and columns of A alike: rounding then costs digits of no state."""
    A, (units, _) = matrix_balance(block.A, permute=False, separate=True)
    return replace(block, A=A, B=block.B / units[:, None], C=block.C * units)


def _number(law: str, value: Fraction | int) -> float:
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{law}: a coefficient of size 1e308 or more cannot be simulated") from None


def leading(coefficients: Sequence[Fraction]) -> list[Fraction]:
    """Coefficients without leading zeros."""
    first = next((i for i, value in enumerate(coefficients) if value), len(coefficients))
    return list(coefficients[first:])


def _time_scale(monic: Sequence[Fraction]) -> Fraction:
    """Power of two near the geometric mean of the nonzero roots' magnitudes."""
    last = max(i for i, value in enumerate(monic) if value)
    bits = abs(monic[last].numerator).bit_length() - monic[last].denominator.bit_length()
    return Fraction(2) ** round(bits / max(last, 1))


def connect(blocks: Sequence[Block], inputs: Sequence[str] = (), outputs: Sequence[str] | None = None) -> Block:
    """Interconnect blocks by signal name; algebraic loops are solved, `v = C x + D (S v + E u)`.

    Args: `inputs`: external signals; `outputs`: the signals to keep, all of them by default.
    Returns: one block; its state is the blocks' states in order.
    Raises: RobimpError naming the loop when the algebraic equations are singular.
    """
    signals = list(chain.from_iterable(block.outputs for block in blocks))
    wanted = list(chain.from_iterable(block.inputs for block in blocks))
    sources = [*signals, *inputs]
    route = np.zeros((len(wanted), len(sources)))
    for port, name in enumerate(wanted):
        route[port, sources.index(name)] = 1
    S, E = route[:, : len(signals)], route[:, len(signals) :]
    A, B, C, D = (_diagonal([getattr(block, name) for block in blocks]) for name in "ABCD")
    solved = _solved(D @ S, signals)
    state, external = solved @ C, solved @ D @ E
    kept = [signals.index(name) for name in (signals if outputs is None else outputs)]
    return Block(
        tuple(inputs), tuple(signals[i] for i in kept),
        A + B @ S @ state, B @ (S @ external + E), state[kept], external[kept],
    )  # fmt: skip


def _diagonal(matrices: Sequence[Matrix]) -> Matrix:
    """Blocks without states or inputs have empty matrices; their other dimension still counts."""
    whole = np.zeros(np.sum([part.shape for part in matrices], axis=0))
    row = column = 0
    for part in matrices:  # SciPy's block_diag takes a hundred times as long for so many small ones
        whole[row : row + part.shape[0], column : column + part.shape[1]] = part
        row, column = row + part.shape[0], column + part.shape[1]
    return whole


def _solved(feedthrough: Matrix, signals: Sequence[str]) -> Matrix:
    """`(1 − feedthrough)⁻¹`: signals by the static laws that make them, loops solved."""
    members = _loop_members(feedthrough, signals)
    one = np.eye(len(signals))
    if not members:
        # Plain substitution keeps exact zeros zero, where elimination leaves rounding.
        series = one
        for _ in signals:
            series = one + feedthrough @ series
        return series
    # The determinant is 1 − loop gain, whatever the units of the signals.
    if abs(np.linalg.det(one - feedthrough)) < WELL_POSED:
        raise RobimpError(f"singular algebraic loop through {', '.join(members)}")
    return np.linalg.inv(one - feedthrough)


def _loop_members(feedthrough: Matrix, signals: Sequence[str]) -> list[str]:
    """Signals that reach themselves without passing a state."""
    reach = (feedthrough != 0).astype(int)
    for _ in signals:
        reach = np.minimum(reach + reach @ reach, 1)
    return [signal for i, signal in enumerate(signals) if reach[i, i]]
