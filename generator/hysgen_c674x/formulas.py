"""Cycles on the C674x as formulas in rules L, plays m and learned parameters n: of gcc's code, and of the kernels.

FORMULAS: fitted to gcc's code, measured with `python benchmarks/target_cycles.py`, stall-free, longest way; least
squares of the relative deviation. Valid for 2 to 12 rules and 6 to 24 parameters. The formulas behind a path hold for
six rules and 4 to 24 plays, 2 Duhem states, 4 creep states and one mode; those of the steps lie between plays with
coefficients of their own and plays that share them (least largest deviation). Plays that relax have formulas of their
own, fitted to 4, 8 and 12 plays of degree 3 with coefficients of their own and valid for 4 to 12 plays. The inverse
behind a path: with three Newton steps.

KERNELS: fitted to the schedules of the same models, with 2 to 12 rules, with 6, 9, 12 and 18 parameters and with 4 to
24 plays, those of the steps to plays that share coefficients, too; least largest relative deviation. The errors include
5 rules and 6 plays, which were not fitted. With 24 parameters the parts of `learn` are kernels, not the whole; behind a
path, its formula is that of 18.
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
    Formula("inverse", ((891.0, ""), (19.4, "m")), 0.06, path=True),
    Formula("learn", ((1333.0, ""), (9.08, "n"), (6.93, "n^2"), (12.1, "m")), 0.05, path=True),
    Formula("commit", ((69.0, ""), (33.9, "L"), (4.73, "L^2")), 0.15, path=True),
    Formula("predict", ((320.0, ""), (146.0, "m")), 0.06, path=True, relaxes=True),
    Formula("simulate", ((320.0, ""), (144.5, "m")), 0.06, path=True, relaxes=True),
    Formula("inverse", ((885.0, ""), (152.0, "m")), 0.06, path=True, relaxes=True),
    Formula("learn", ((1235.0, ""), (9.08, "n"), (6.93, "n^2"), (146.0, "m")), 0.05, path=True, relaxes=True),
    Formula("commit", ((69.0, ""), (33.9, "L"), (4.73, "L^2")), 0.15, path=True, relaxes=True),
)

KERNELS: Final[Sequence[Formula]] = (
    Formula("predict", ((109.0, ""), (2.14, "L")), 0.03),
    Formula("simulate", ((106.0, ""), (2.34, "L")), 0.03),
    Formula("inverse", ((127.6, ""), (2.04, "L")), 0.03),
    Formula("snapshot", ((5.1, ""), (30.4, "L")), 0.16),
    Formula("learn", ((46.1, ""), (43.9, "n")), 0.06),
    Formula("predict", ((133.0, ""), (5.02, "m")), 0.1, path=True),
    Formula("simulate", ((151.0, ""), (3.97, "m")), 0.11, path=True),
    Formula("inverse", ((630.0, ""), (4.69, "m")), 0.03, path=True),
    Formula("snapshot", ((160.0, ""),), 0.07, path=True),
    Formula("learn", ((1011.0, ""), (6.69, "m")), 0.02, path=True),
)

NEWTON_STEPS: Final = 3
"""Newton steps of the inverse behind the path that the formulas describe."""

MOST_IN_KERNEL: Final = 18
"""Most learned parameters of a learner that becomes one kernel."""


def formulas(model: Model, among: Sequence[Formula] = FORMULAS) -> list[tuple[Formula, int]]:
    """The formulas of `among` that hold for the structure of `model`, each with its value."""
    rules, kinds = model.grid.rules, [block.kind for block in model.blocks]
    if model.terms or not 2 <= rules <= 12 or (kinds and (kinds != PATH or rules != 6)):
        return []
    hysteresis = [block for block in model.blocks if isinstance(block, Hysteresis)]
    relaxes, plays = any(block.relaxes for block in hysteresis), sum(block.plays for block in hysteresis)
    if relaxes and not (4 <= plays <= 12 and hysteresis[0].degree == 3):
        return []
    longer = any(block.steps != NEWTON_STEPS for block in hysteresis)
    n = learner_numbers(model, coefficients(model)).size if model.learner else 0
    return [
        (formula, formula.cycles(rules, plays, n))
        for formula in among
        if (formula.path, formula.relaxes) == (bool(kinds), relaxes)
        and (6 <= n <= 24 or formula.function not in ("learn", "commit", "snapshot"))
        and not (longer and formula.function == "inverse")
    ]


def kernel_formulas(model: Model) -> list[tuple[Formula, int]]:
    """The formulas that hold for the kernels of `model`, each with its value."""
    n = learner_numbers(model, coefficients(model)).size if model.learner else 0
    learns = n == MOST_IN_KERNEL if model.blocks else n <= MOST_IN_KERNEL
    return [each for each in formulas(model, KERNELS) if learns or each[0].function != "learn"]


def formula_lines(about: str, found: Sequence[tuple[Formula, int]]) -> list[str]:
    """A line of text for each formula with its value and error, below `about`; none without a formula."""
    lines = [f"  {f.function} = {f} = {value} (+-{100 * f.error:.0f} %)" for f, value in found]
    return [f"C674x cycles of {about} as formulas in rules L, plays m and parameters n:", *lines] if lines else []
