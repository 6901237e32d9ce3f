"""Cycles on the C674x as formulas in rules L, plays m and learned parameters n, fitted to cycles of gcc's code.

Measured with `python benchmarks/target_cycles.py`, stall-free, longest way; least squares of the relative deviation.
Valid for 2 to 12 rules and 6 to 24 parameters. The formulas behind a path hold for six rules and 4 to 24 plays, 2 Duhem
states, 4 creep states and one mode; those of the steps lie between plays with coefficients of their own and plays that
share them (least largest deviation). Plays that relax have formulas of their own, fitted to 4, 8 and 12 plays of degree
3 with coefficients of their own and valid for 4 to 12 plays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis

PATH: Final = ["hysteresis", "creep", "modes"]
"""Blocks of the path that the formulas with plays describe."""


@dataclass(frozen=True)
class Formula:
    """Cycles of a call of `function`: the sum of coefficient times power over `terms`.

    terms: (coefficient, variables), the variables one of "", "L", "L^2", "m", "n", "n^2". path: whether it holds behind
    a path. relaxes: whether it holds for plays that relax. error: largest relative deviation of a measured size.
    """

    function: str
    terms: tuple[tuple[float, str], ...]
    error: float
    path: bool = False
    relaxes: bool = False

    def cycles(self, rules: int, plays: int, parameters: int) -> int:
        """The value of the formula, rounded."""
        known = {"": 1, "L": rules, "L^2": rules**2, "m": plays, "n": parameters, "n^2": parameters**2}
        return round(sum(coefficient * known[variables] for coefficient, variables in self.terms))

    def __str__(self) -> str:
        return " + ".join(f"{coefficient:.3g} {variables}".rstrip() for coefficient, variables in self.terms)


FORMULAS: Final[Sequence[Formula]] = (
    Formula("predict", ((120.0, ""), (7.6, "L")), 0.13),
    Formula("simulate", ((117.0, ""), (7.0, "L")), 0.13),
    Formula("inverse", ((130.0, ""), (11.5, "L")), 0.07),
    Formula("learn", ((1060.0, ""), (9.08, "n"), (6.93, "n^2")), 0.05),
    Formula("commit", ((69.0, ""), (33.9, "L"), (4.73, "L^2")), 0.15),
    Formula("predict", ((363.0, ""), (12.0, "m")), 0.06, path=True),
    Formula("simulate", ((362.0, ""), (11.1, "m")), 0.06, path=True),
    Formula("inverse", ((914.0, ""), (19.3, "m")), 0.04, path=True),
    Formula("learn", ((1333.0, ""), (9.08, "n"), (6.93, "n^2"), (12.1, "m")), 0.05, path=True),
    Formula("commit", ((69.0, ""), (33.9, "L"), (4.73, "L^2")), 0.15, path=True),
    Formula("predict", ((320.0, ""), (146.0, "m")), 0.06, path=True, relaxes=True),
    Formula("simulate", ((320.0, ""), (144.5, "m")), 0.06, path=True, relaxes=True),
    Formula("inverse", ((885.0, ""), (152.0, "m")), 0.06, path=True, relaxes=True),
    Formula("learn", ((1235.0, ""), (9.08, "n"), (6.93, "n^2"), (146.0, "m")), 0.05, path=True, relaxes=True),
    Formula("commit", ((69.0, ""), (33.9, "L"), (4.73, "L^2")), 0.15, path=True, relaxes=True),
)


def formulas(model: Model) -> list[tuple[Formula, int]]:
    """The formulas that hold for the structure of `model`, each with its value."""
    rules, kinds = model.grid.rules, [block.kind for block in model.blocks]
    if model.terms or not 2 <= rules <= 12 or (kinds and (kinds != PATH or rules != 6)):
        return []
    hysteresis = [block for block in model.blocks if isinstance(block, Hysteresis)]
    relaxes, plays = any(block.relaxes for block in hysteresis), sum(block.plays for block in hysteresis)
    if relaxes and not (4 <= plays <= 12 and hysteresis[0].degree == 3):
        return []
    n = learner_numbers(model, coefficients(model)).size if model.learner else 0
    return [
        (formula, formula.cycles(rules, plays, n))
        for formula in FORMULAS
        if (formula.path, formula.relaxes) == (bool(kinds), relaxes)
        and (6 <= n <= 24 or formula.function not in ("learn", "commit"))
    ]
