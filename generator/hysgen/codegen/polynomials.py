"""Sums over the rules as lines of C: the intermediate values of Estrin's scheme and of pairwise summation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

Joining = Callable[[int, str, str], str]
"""C text of the combination of two neighbours, from level, left and right text."""


@dataclass(frozen=True)
class Step:
    """The assignment `name = text` in C."""

    name: str
    text: str


@dataclass(frozen=True)
class Sum:
    """A sum over the rules: assignments of the intermediate values in order, and the C expression of the sum."""

    name: str
    steps: Sequence[Step]
    value: str


def squares(count: int) -> list[Step]:
    """Assignments of r2, r4, r8, ... for a polynomial of `count` coefficients in r by Estrin's scheme.

    >>> [f"{step.name} = {step.text}" for step in squares(6)]
    ['r2 = r * r', 'r4 = r2 * r2']
    """
    steps: list[Step] = []
    exponent = 2
    while exponent < count:
        half = _power(exponent // 2)
        steps.append(Step(_power(exponent), f"{half} * {half}"))
        exponent *= 2
    return steps


def powers(count: int) -> list[Step]:
    """Assignments of r2, r3, ... r<count - 1> by r^k = r^(k//2) r^(k - k//2), the fewest multiplications in sequence.

    >>> [f"{step.name} = {step.text}" for step in powers(5)]
    ['r2 = r * r', 'r3 = r * r2', 'r4 = r2 * r2']
    """
    return [Step(_power(k), f"{_power(k // 2)} * {_power(k - k // 2)}") for k in range(2, count)]


def polynomial(name: str, coefficients: Sequence[str]) -> Sum:
    """sum_k coefficients[k] r^k by Estrin's scheme: neighbours combine as a + b r, the results with r2, then r4, ..."""
    return _joined(name, coefficients, lambda level, left, right: f"{left} + {right} * {_power(2**level)}")


def pairs(name: str, products: Sequence[str]) -> Sum:
    """The sum of `products` by pairwise summation."""
    return _joined(name, products, lambda _, left, right: f"{left} + {right}")


def _joined(name: str, texts: Sequence[str], join: Joining) -> Sum:
    """Pairwise combination of `texts`; an intermediate is named by the first letter of `name`, first and last row."""
    parts = [(text, row, row) for row, text in enumerate(texts)]
    steps: list[Step] = []
    level = 0
    while len(parts) > 1:
        neighbours = []
        for (left, first, _), (right, _, last) in zip(parts[0::2], parts[1::2], strict=False):
            steps.append(Step(f"{name[0]}{first}_{last}", join(level, left, right)))
            neighbours.append((steps[-1].name, first, last))
        parts = [*neighbours, *parts[2 * len(neighbours) :]]
        level += 1
    return Sum(name, steps[:-1], steps[-1].text)


def _power(exponent: int) -> str:
    return "r" if exponent == 1 else f"r{exponent}"
