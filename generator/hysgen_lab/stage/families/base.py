"""The contract of a family of hysteresis: drawn from random numbers, scaled to a stroke and a loop opening."""

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import StageError
from hysgen_lab.stage.effects.memory import Form, Hysteresis
from hysgen_lab.stage.measure import static_loop

Floats = NDArray[np.float64]

MOST_DRAWS = 50


@dataclass(frozen=True)
class Family(Hysteresis):
    """w = slope_um_per_V u + height_um m(u), with a hysteresis m that is linear in its height.

    low_V, high_V: range of the voltage that the hysteresis is drawn for. kind: number of the equation in plant.h. The
    displacement is given in um: `Stage.stroke_um` and `Stage.full_V` have no part in it.
    """

    kind: ClassVar[int]

    low_V: float
    high_V: float
    slope_um_per_V: float = 0.0
    height_um: float = 1.0

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        """A hysteresis with random parameters and a height of 1 um, for a stage sampled every Ts_s."""
        raise NotImplementedError

    @property
    def steepest_fall_um_per_V(self) -> float:
        """Largest -dm/du times the height, over every path: the slope must exceed it, or w moves against u."""
        return 0.0

    def form(self, stroke_um: float, full_V: float) -> Form:
        scalars, arrays = self.equation()
        return Form(self.kind, {"slope_um_per_V": self.slope_um_per_V, "grid_n": 2} | scalars, arrays)

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        """Scalars and arrays of m, by the names of `hysteresis_t` in plant.h, with the height applied."""
        raise NotImplementedError

    def scaled(self, stroke_um: float, opening_um: float) -> Self:
        """The hysteresis with this closed stroke and this largest opening of the loop over low_V .. high_V."""
        bare = dataclasses.replace(self, slope_um_per_V=0.0, height_um=1.0)
        _, rising, falling = static_loop(around(bare), self.low_V, self.high_V)
        height_um = opening_um / float((falling - rising).max())
        slope = (stroke_um - height_um * float(rising[-1] - rising[0])) / (self.high_V - self.low_V)
        return dataclasses.replace(self, slope_um_per_V=slope, height_um=height_um)


def scattered(rng: np.random.Generator, count: int, dimensions: int) -> Floats:
    """(count, dimensions) random points in the unit cube that fill it more evenly than independent ones.

    A Kronecker sequence on powers of the generalised golden ratio, with a random start and a random shift of each point
    by up to half the mean distance of neighbours.
    """
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    points = rng.random(dimensions) + np.arange(count)[:, None] * steps
    shifts = (rng.random((count, dimensions)) - 0.5) * count ** (-1.0 / dimensions)
    return np.asarray((points + shifts) % 1.0, dtype=np.float64)


def around(hysteresis: Family) -> Stage:
    """A stage of this hysteresis and no other effect, with ideal converters and without a lag."""
    low_V, high_V = hysteresis.low_V, hysteresis.high_V
    return Stage(
        lag_s=0.0,
        dac_low_V=low_V - (high_V - low_V),
        dac_high_V=high_V + (high_V - low_V),
        dac_bits=0,
        history_V=(low_V, high_V, low_V),
        zero_V=low_V,
        memory=hysteresis,
    ).quiet()


def draw(
    kind: type[Family], rng: np.random.Generator, range_V: tuple[float, float], Ts_s: float, stroke_um: float
) -> Family:
    """A hysteresis with a loop opening of 5 to 20 % of the stroke, whose output never moves against the input.

    Raises StageError if MOST_DRAWS draws give no such hysteresis.
    """
    opening_um = float(rng.uniform(0.05, 0.2)) * stroke_um
    for _ in range(MOST_DRAWS):
        made = kind.drawn(rng, *range_V, Ts_s).scaled(stroke_um, opening_um)
        if made.slope_um_per_V > 1.05 * made.steepest_fall_um_per_V:
            return made
    raise StageError(f"{kind.__name__}: no output of {MOST_DRAWS} draws rises with the input; choose another seed")
