"""The laws of the five families of hysteresis; none is made of play operators or of Duhem states.

A family is drawn from random numbers, scaled to a stroke and a loop opening.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import StageError, require
from hysgen_lab.stage.effects.memory import (
    KIND_BOUC_WEN,
    KIND_JILES_ATHERTON,
    KIND_MESH,
    KIND_RELAYS,
    KIND_THERMAL,
    Form,
    Hysteresis,
)
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


CELLS = 560
MARGIN = 0.2
"""Cells of the mesh along each axis, over the voltage range and this share of it beyond each end."""


@dataclass(frozen=True)
class MeshPreisach(Family):
    """Preisach density of groups of relays in coercive voltage h and bias c, alpha = c + h, beta = c - h:

        mu(alpha, beta) = sum_g weight_g exp(-(c - bias_g - tilt_g h)^2 / (2 width_g^2)) f_g(h / coercive_g)

    f_g(s) = exp(-ln(s)^2 / (2 spread_g^2)) / s, a log-normal density, or 1 / (1 + s^2)^2 if spread_g = 0. A tilt makes
    wide relays stand elsewhere than narrow ones. groups: (weight, bias_V, width_V, tilt, coercive_V, spread) of each.
    Source: Mayergoyz, Mathematical Models of Hysteresis, chapter 1; Della Torre for the coordinates.
    """

    groups: tuple[tuple[float, float, float, float, float, float], ...] = ()

    kind = KIND_MESH

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        groups = []
        for shape in (0.0, *rng.uniform(0.3, 0.8, rng.integers(1, 4))):
            bias_V, width_V = low_V + span_V * rng.uniform(0.2, 0.8), span_V * rng.uniform(0.15, 0.5)
            tilt, coercive_V = rng.uniform(-0.6, 0.6), span_V * np.exp(rng.uniform(np.log(0.05), np.log(0.25)))
            weight = rng.uniform(0.4, 1.0) / (width_V * coercive_V)
            groups.append((float(weight), float(bias_V), width_V, float(tilt), float(coercive_V), float(shape)))
        return cls(low_V, high_V, groups=tuple(groups))

    def density(self, alpha_V: Floats, beta_V: Floats) -> Floats:
        """mu at each point, mirrored beyond the diagonal of the plane: the shape of alpha_V."""
        c, h = (alpha_V + beta_V) / 2, np.abs(alpha_V - beta_V) / 2
        total = np.zeros(np.shape(h))
        for weight, bias_V, width_V, tilt, coercive_V, spread in self.groups:
            s = h / coercive_V + 1e-9
            sizes = np.exp(-(np.log(s) ** 2) / (2 * spread**2)) / s if spread else (1 + s**2) ** -2
            total += weight * np.exp(-((c - bias_V - tilt * h) ** 2) / (2 * width_V**2)) * sizes
        return total

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        span_V = self.high_V - self.low_V
        step_V = span_V * (1 + 2 * MARGIN) / CELLS
        first_V = self.low_V - MARGIN * span_V
        # Four points in each cell.
        at_V = first_V + step_V * (np.arange(2 * CELLS) + 0.5) / 2
        mass = self.density(at_V[:, None], at_V).reshape(CELLS, 2, CELLS, 2).mean(axis=(1, 3)) * step_V**2
        corner = np.zeros((CELLS + 1, CELLS + 1))
        corner[1:, 1:] = self.height_um * mass.cumsum(axis=0).cumsum(axis=1)
        i = np.arange(CELLS)
        rise = corner[i + 1, i] - corner[i, i] + 0.5 * self.height_um * np.diag(mass)
        diagonal = np.concatenate(([0.0], np.cumsum(rise)))
        scalars = {"grid_low_V": first_V, "grid_step_V": step_V, "grid_n": CELLS + 1}
        return scalars, {"corner": corner, "diagonal": diagonal}


RELAYS = 60_000
"""Number of relays: each moves the output by less than half the rms of the noise."""


@dataclass(frozen=True)
class RandomRelays(Family):
    """Relays that switch on at bias + coercive and off at bias - coercive, in V, with random weights.

    bias: Kumaraswamy-distributed over the range, exponents `bias_shape`. coercive: Weibull-distributed, scale
    coercive_V, exponent `coercive_shape`, narrower by the share `pinched` at the ends of the range. weights: uniform,
    0.3 to 1.7 of their mean. seed: of thresholds and weights.
    Source: Preisach (1935).
    """

    bias_shape: tuple[float, float] = (1.5, 1.5)
    coercive_V: float = 10.0
    coercive_shape: float = 1.2
    pinched: float = 0.0
    seed: int = 0

    kind = KIND_RELAYS

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        return cls(
            low_V,
            high_V,
            bias_shape=(float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 3.0))),
            coercive_V=(high_V - low_V) * float(rng.uniform(0.06, 0.25)),
            coercive_shape=float(rng.uniform(0.8, 2.0)),
            pinched=float(rng.uniform(0.0, 0.7)),
            seed=int(rng.integers(2**31)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        rng = np.random.default_rng(self.seed)
        unit = scattered(rng, RELAYS, 2)
        place = (1 - (1 - unit[:, 0]) ** (1 / self.bias_shape[1])) ** (1 / self.bias_shape[0])
        width = self.coercive_V * (-np.log1p(-unit[:, 1])) ** (1 / self.coercive_shape)
        width *= 1 - self.pinched * (2 * place - 1) ** 2
        bias_V = self.low_V + (self.high_V - self.low_V) * (1.2 * place - 0.1)
        up_V, down_V = bias_V + width, bias_V - width
        weight_um = self.height_um * rng.uniform(0.3, 1.7, RELAYS) / RELAYS
        order = np.argsort(up_V, kind="stable")
        down_V = down_V[order]
        arrays: dict[str, NDArray[Any]] = {
            "up_V": up_V[order],
            "down_V": down_V,
            "weight_um": weight_um,
            "down_order": np.argsort(down_V, kind="stable").astype(np.int32),
            "on": np.zeros(RELAYS, dtype=np.uint8),
        }
        return {"relays": RELAYS}, arrays


@dataclass(frozen=True)
class RisingBoucWen(Family):
    """w = slope u - z,  dz/du = (height / reach) (1 - (balance sign(z du) + 1 - balance) |z / height|^exponent).

    dw/du > 0 on every path if the slope exceeds (height / reach) max(1, 2 balance), the rate of z after a turn.
    With exponent 1 and balance 1 it would be a Duhem operator that decays with the path; neither is drawn.
    Source: Wen (1976); Low and Guo (1995) for piezo actuators.
    """

    reach_V: float = 20.0
    balance: float = 0.6
    exponent: float = 1.5

    kind = KIND_BOUC_WEN

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        return cls(
            low_V,
            high_V,
            reach_V=span_V * float(np.exp(rng.uniform(np.log(0.08), np.log(0.4)))),
            balance=float(rng.uniform(0.5, 0.85)),
            exponent=float(rng.uniform(1.1, 2.0)),
        )

    @property
    def steepest_fall_um_per_V(self) -> float:
        return self.height_um / self.reach_V * max(1.0, 2 * self.balance)

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        first = self.height_um / self.reach_V
        total = first / self.height_um**self.exponent
        scalars = {
            "grid_low_V": self.low_V - 0.2 * (self.high_V - self.low_V),
            "bw_a": first,
            "bw_beta": self.balance * total,
            "bw_gamma": (1 - self.balance) * total,
            "bw_n": self.exponent,
        }
        return scalars, {}


@dataclass(frozen=True)
class JilesAtherton(Family):
    """w = slope u + height m, with the magnetisation m of jiles_atherton.c over the field u - centre_V.

    shape_V: of the Langevin curve. pinning_V: of the domain walls. coupling_V: field that m = 1 adds to the field.
    reversible: share of the anhysteretic curve in m. dm/du is bounded and not negative if
    coupling (reversible / (3 shape) + 2 (1 - reversible) / pinning) < 1.
    Source: Jiles and Atherton (1986).
    """

    centre_V: float = 50.0
    shape_V: float = 25.0
    pinning_V: float = 20.0
    coupling_V: float = 5.0
    reversible: float = 0.2

    kind = KIND_JILES_ATHERTON

    def __post_init__(self) -> None:
        steepest = self.reversible / (3 * self.shape_V) + 2 * (1 - self.reversible) / self.pinning_V
        require(self.coupling_V * steepest < 1, "JilesAtherton.coupling_V: the magnetisation jumps; choose less")

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        shape_V, pinning_V = span_V * float(rng.uniform(0.1, 0.3)), span_V * float(rng.uniform(0.1, 0.35))
        return cls(
            low_V,
            high_V,
            centre_V=low_V + span_V * float(rng.uniform(0.35, 0.65)),
            shape_V=shape_V,
            pinning_V=pinning_V,
            coupling_V=float(rng.uniform(0.05, 0.35)) * pinning_V,
            reversible=float(rng.uniform(0.05, 0.4)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        scalars = {
            "grid_low_V": self.low_V - 0.2 * (self.high_V - self.low_V),
            "ja_centre_V": self.centre_V,
            "ja_shape_V": self.shape_V,
            "ja_coupling_V": self.coupling_V,
            "ja_pinning_V": self.pinning_V,
            "ja_reversible": self.reversible,
            "ja_height_um": self.height_um,
        }
        return scalars, {}


HYSTERONS = 1024


@dataclass(frozen=True)
class ThermalHysterons(Family):
    """Hysterons of random bias, coercive voltage and barrier; equations in thermal.c.

    bias: Kumaraswamy-distributed over the range, exponents `bias_shape`; coercive voltages: log-logistic of median
    coercive_V, standard deviation `coercive_spread` of the logarithm; barriers, in units of kT and without field:
    log-logistic of median `barrier`, standard deviation `barrier_spread`.
    attempt_per_s: attempts to leave a well per second. hold_s: how long each voltage of a path without time is held.
    substep_s: substep of the plant, within which the output is taken as linear in time.
    Source: Neel (1949); Brown (1963).
    """

    bias_shape: tuple[float, float] = (1.5, 1.5)
    coercive_V: float = 30.0
    coercive_spread: float = 0.5
    barrier: float = 70.0
    barrier_spread: float = 0.4
    attempt_per_s: float = 1e9
    hold_s: float = 1e-3
    substep_s: float = 1e-3
    seed: int = 0

    kind = KIND_THERMAL

    @property
    def longest_substep_s(self) -> float:  # type: ignore[override]
        return self.substep_s

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        return cls(
            low_V,
            high_V,
            bias_shape=(float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 3.0))),
            coercive_V=(high_V - low_V) * float(rng.uniform(0.15, 0.4)),
            coercive_spread=float(rng.uniform(0.3, 0.7)),
            barrier=float(np.exp(rng.uniform(np.log(45), np.log(150)))),
            barrier_spread=float(rng.uniform(0.2, 0.5)),
            attempt_per_s=10 ** float(rng.uniform(3, 6)) / Ts_s,
            hold_s=4 * Ts_s,
            substep_s=0.5 * Ts_s,
            seed=int(rng.integers(2**31)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        rng = np.random.default_rng(self.seed)
        unit = scattered(rng, HYSTERONS, 3)
        place = (1 - (1 - unit[:, 0]) ** (1 / self.bias_shape[1])) ** (1 / self.bias_shape[0])
        logistic = np.log(unit[:, 1:] / (1 - unit[:, 1:])) * np.sqrt(3) / np.pi
        coercive_V = self.coercive_V * np.exp(self.coercive_spread * logistic[:, 0])
        arrays = {
            "bias_V": self.low_V + (self.high_V - self.low_V) * (1.2 * place - 0.1),
            "per_coercive_V": 1 / coercive_V,
            "barrier": self.barrier * np.exp(self.barrier_spread * logistic[:, 1]),
            "part_um": self.height_um * rng.uniform(0.3, 1.7, HYSTERONS) / HYSTERONS,
            "up": np.zeros(HYSTERONS),
        }
        return {"hysterons": HYSTERONS, "attempt_per_s": self.attempt_per_s, "dwell_s": self.hold_s}, arrays
