"""Estrin's scheme written out: the products and sums that a polynomial of a given length takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Power:
    """`name` is the square of `half`."""

    name: str
    half: str


@dataclass(frozen=True)
class Step:
    """name = left + right * power."""

    name: str
    left: str
    right: str
    power: str


@dataclass(frozen=True)
class Sum:
    """One polynomial: its steps but the last, and the last, whose value is the polynomial."""

    name: str
    steps: Sequence[Step]
    last: Step


def powers(count: int) -> list[Power]:
    """Squares r2, r4, r8, ... that a polynomial of `count` coefficients in r needs."""
    found: list[Power] = []
    exponent = 1
    while 2 * exponent < count:
        found.append(Power(name=f"r{2 * exponent}", half="r" if exponent == 1 else f"r{exponent}"))
        exponent *= 2
    return found


def polynomial(name: str, coefficients: Sequence[str]) -> Sum:
    """sum_k coefficients[k] r^k: neighbours join as a + b r, then with r2, r4, ... until one is left.

    A step is named by the first letter of `name` and the coefficients that it covers.
    """
    parts = [(text, k, k) for k, text in enumerate(coefficients)]
    steps: list[Step] = []
    exponent = 1
    while len(parts) > 1:
        joined = []
        for (left, first, _), (right, _, last) in zip(parts[0::2], parts[1::2], strict=False):
            step = Step(f"{name[0]}{first}_{last}", left, right, "r" if exponent == 1 else f"r{exponent}")
            steps.append(step)
            joined.append((step.name, first, last))
        parts = [*joined, *parts[2 * len(joined) :]]
        exponent *= 2
    return Sum(name, steps[:-1], steps[-1])


def pairs(names: Sequence[str]) -> str:
    """The sum of `names` as C text, neighbours first, then neighbours of those.

    >>> pairs(["a", "b", "c", "d", "e"])
    '((a + b) + (c + d)) + e'
    """
    parts = list(names)
    while len(parts) > 1:
        joined = [f"({parts[k]} + {parts[k + 1]})" for k in range(0, len(parts) - 1, 2)]
        parts = [*joined, *parts[2 * len(joined) :]]
    return parts[0].removeprefix("(").removesuffix(")")
