"""Memory: hysteresis of the ceramic by Preisach (Everett function, or relays) or Bouc-Wen, or a single-valued curve.

None of them contains play operators. Each gives the displacement w [um] as a rate-independent functional of the path of
the voltage u [V] with w(zero_V) = 0 after its voltage history. `Preisach` and `Relays` compute the same operator by two
independent methods; tests compare them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects import Effect, StageError, require, require_finite

Floats = NDArray[np.float64]

GRID_LOW_V, GRID_HIGH_V, GRID_STEP_V = -60.0, 160.0, 0.05
GAUSS_POINTS = 5  # per cell of 0.05 V: exact to rounding for densities that vary over tens of volts

# The kinds of plant.h.
KIND_CURVE, KIND_EVERETT, KIND_RELAYS, KIND_BOUC_WEN, KIND_MESH, KIND_JILES_ATHERTON, KIND_THERMAL = range(7)


@dataclass(frozen=True)
class Form:
    """Constants of a hysteresis in the compiled plant: scalars and arrays by the names of `hysteresis_t` in plant.h."""

    kind: int
    scalars: dict[str, float]
    arrays: dict[str, NDArray[Any]]


class Hysteresis(Effect):
    """Base of the hysteresis of the ceramic, the one effect that every stage of the bank has."""

    name = "memory"
    rank = 0

    @classmethod
    def made(cls, value: Any) -> Hysteresis:
        if not isinstance(value, cls):
            raise StageError("memory: give Preisach, Relays, BoucWen, Curve or None")
        return value

    def form(self, stroke_um: float, full_V: float) -> Form:
        """Form with a closed stroke of stroke_um over 0 .. full_V."""
        raise NotImplementedError


@dataclass(frozen=True)
class Density:
    """Density of the relays on the Preisach plane, alpha >= beta: the thresholds at which domains switch.

        mu(alpha, beta) = a(alpha) b(beta)  ~  exp(-(alpha - beta)/decay_V)
                          / (1 + ((alpha - on_V)/width_V)^2) / (1 + ((beta - off_V)/width_V)^2)

    Narrow relays are more frequent than wide ones, and there are most near the middle of the range. The density depends
    on alpha + beta too, so that no superposition of play operators can equal it.
    """

    decay_V: float = 40.0
    on_V: float = 60.0
    off_V: float = 20.0
    width_V: float = 65.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.decay_V > 5 and self.width_V > 5, "Density: decay_V and width_V below 5 V are not resolved; widen")

    def on(self, alpha_V: Floats) -> Floats:
        """a(alpha), unscaled: same shape as `alpha_V`."""
        falling: Floats = np.exp(-(alpha_V - 50.0) / self.decay_V) / (1 + ((alpha_V - self.on_V) / self.width_V) ** 2)
        return falling

    def off(self, beta_V: Floats) -> Floats:
        """b(beta), unscaled: same shape as `beta_V`."""
        rising: Floats = np.exp((beta_V - 50.0) / self.decay_V) / (1 + ((beta_V - self.off_V) / self.width_V) ** 2)
        return rising


@dataclass(frozen=True)
class Preisach(Hysteresis):
    """Preisach hysteresis with a continuous density, evaluated exactly from its turning points.

        w = slope u + sum of +-E(M, m) over the remembered monotone pieces,
        E(M, m) = G(M) (H(M) - H(m)) - (K(M) - K(m)),   G' = a,  H' = b,  K' = G b

    irreversible: share of the closed full stroke that the relays make; the rest follows the voltage reversibly.
    Source: Everett (1955); Mayergoyz, Mathematical Models of Hysteresis, chapter 1.
    """

    density: Density = Density()
    irreversible: float = 0.38

    def __post_init__(self) -> None:
        require(0 < self.irreversible < 1, "Preisach.irreversible: must lie between 0 and 1; use memory=None for 0")

    def form(self, stroke_um: float, full_V: float) -> Form:
        nodes_V, table = everett_table(self.density)
        scale = self.irreversible * stroke_um / everett(nodes_V, table, full_V, 0.0)
        table = table * np.array([scale, scale, 1.0, 1.0, scale, scale])  # G and K carry the density's height
        return Form(
            KIND_EVERETT,
            {"slope_um_per_V": (1 - self.irreversible) * stroke_um / full_V, "grid_n": len(nodes_V)},
            {"table": np.ascontiguousarray(table)},
        )


@dataclass(frozen=True)
class Relays(Hysteresis):
    """Preisach hysteresis by its definition: `count` x `count` / 2 relays, whose output is a staircase.

    Relay (alpha, beta): switches on at u >= alpha, off at u <= beta; its weight is the density at its place times the
    area of its cell. Source: Preisach (1935).
    """

    density: Density = Density()
    irreversible: float = 0.38
    count: int = 140

    def __post_init__(self) -> None:
        require(0 < self.irreversible < 1, "Relays.irreversible: must lie between 0 and 1; use memory=None for 0")
        require(2 <= self.count <= 2000, f"Relays.count: {self.count} is not built; choose 2 to 2000 per axis")

    def form(self, stroke_um: float, full_V: float) -> Form:
        edges = np.linspace(GRID_LOW_V, GRID_HIGH_V, self.count + 1)
        centres, cell = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
        up, down = np.meshgrid(centres, centres, indexing="ij")
        area = np.where(up > down, cell**2, np.where(up == down, cell**2 / 2, 0.0))
        weight = self.density.on(up) * self.density.off(down) * area
        positive = area > 0
        # Cells on the diagonal are triangles, alpha > beta: the centroid is a sixth of a cell off the cell's centre.
        shift = np.where(up == down, cell / 6, 0.0)
        up_V, down_V, weight = (up + shift)[positive], (down - shift)[positive], weight[positive]
        weight *= self.irreversible * stroke_um / weight[(up_V <= full_V) & (down_V > 0.0)].sum()
        order = np.argsort(up_V, kind="stable")
        up_V, down_V, weight = up_V[order], down_V[order], weight[order]
        return Form(
            KIND_RELAYS,
            {"slope_um_per_V": (1 - self.irreversible) * stroke_um / full_V, "relays": len(up_V), "grid_n": 2},
            {
                "up_V": up_V,
                "down_V": down_V,
                "weight_um": weight,
                "down_order": np.argsort(down_V, kind="stable").astype(np.int32),
                "on": np.zeros(len(up_V), dtype=np.uint8),
            },
        )


@dataclass(frozen=True)
class BoucWen(Hysteresis):
    """Bouc-Wen hysteresis as used for piezo actuators: w = slope u - z.

        dz/du = a - beta sign(du) |z|^(n-1) z - gamma |z|^n,   beta + gamma = a / loop_um^n

    loop_um: where |z| saturates, half the height of a long loop. reach_V = loop_um / a: voltage over which z turns.
    balance: beta / (beta + gamma). Source: Wen (1976); Low and Guo (1995) for piezo actuators.
    """

    loop_um: float = 0.75
    reach_V: float = 18.0
    balance: float = 0.6
    exponent: float = 1.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.loop_um > 0 and self.reach_V > 0, "BoucWen: loop_um and reach_V must be above 0")
        require(0.5 <= self.balance <= 1, "BoucWen.balance: loops turn the wrong way; choose from 0.5 to 1")
        require(self.exponent >= 1, "BoucWen.exponent: below 1 is not smooth; choose from 1 up")

    def form(self, stroke_um: float, full_V: float) -> Form:
        require(5 * self.reach_V <= full_V, "BoucWen.reach_V: the loop never opens; choose a fifth of full_V or less")
        climb = self.loop_um / self.reach_V
        total = climb / self.loop_um**self.exponent
        # On a long stroke z goes from -loop_um to +loop_um; the slope makes up for it.
        slope = (stroke_um + 2 * self.loop_um) / full_V
        scalars = {
            "slope_um_per_V": slope,
            "bw_a": climb,
            "bw_beta": self.balance * total,
            "bw_gamma": (1 - self.balance) * total,
            "bw_n": self.exponent,
            "grid_n": 2,
        }
        return Form(KIND_BOUC_WEN, scalars, {})


@dataclass(frozen=True)
class Curve(Hysteresis):
    """No memory: w is a single-valued function of u, given at uniform voltages, linear between and beyond them."""

    low_V: float
    step_V: float
    w_um: tuple[float, ...]

    active = False  # a single-valued curve has no memory

    def __post_init__(self) -> None:
        require(len(self.w_um) >= 2 and self.step_V > 0, "Curve: at least two points at rising voltages are needed")

    def form(self, stroke_um: float, full_V: float) -> Form:
        del stroke_um, full_V  # the curve is given in micrometres already
        scalars = {"grid_low_V": self.low_V, "grid_step_V": self.step_V, "grid_n": len(self.w_um)}
        return Form(KIND_CURVE, scalars, {"table": np.array(self.w_um)})


def straight(stroke_um: float, full_V: float) -> Curve:
    """The curve without hysteresis: proportional, `stroke_um` over 0 .. full_V."""
    return Curve(0.0, full_V, (0.0, stroke_um))


def everett_table(density: Density) -> tuple[Floats, Floats]:
    """The three functions of which the Everett function of a product density is made, with their derivatives.

    Returns the nodes (n,) in V and (n, 6): G, G', H, H', K, K' with G' = a, H' = b, K' = G b, integrated over
    each cell by Gauss-Legendre, for cubic Hermite interpolation between the nodes.
    """
    n = round((GRID_HIGH_V - GRID_LOW_V) / GRID_STEP_V) + 1
    nodes_V = GRID_LOW_V + GRID_STEP_V * np.arange(n, dtype=np.float64)
    place, weight = (np.asarray(part, dtype=np.float64) for part in np.polynomial.legendre.leggauss(GAUSS_POINTS))
    share = (place + 1) / 2
    at_V = nodes_V[:-1, None] + GRID_STEP_V * share
    on_g, off_g = density.on(at_V), density.off(at_V)

    def running(values: Floats) -> Floats:
        cells = (values * weight).sum(axis=1) * GRID_STEP_V / 2
        return np.concatenate(([0.0], np.cumsum(cells)))

    G = running(on_g)
    # G inside a cell, at each Gauss point: integrate a from the cell's left node with the same rule, squeezed.
    inner_V = nodes_V[:-1, None, None] + GRID_STEP_V * share[:, None] * share
    G_inside = G[:-1, None] + (density.on(inner_V) * weight).sum(axis=2) * GRID_STEP_V * share / 2
    K = running(G_inside * off_g)
    on, off = density.on(nodes_V), density.off(nodes_V)
    return nodes_V, np.stack([G, on, running(off_g), off, K, G * off], axis=1)


def everett(nodes_V: Floats, table: Floats, high_V: float, low_V: float) -> float:
    """E(high, low) at two nodes of the table: displacement switched on by a rise from low_V to high_V."""
    high, low = (table[int(np.argmin(np.abs(nodes_V - at_V)))] for at_V in (high_V, low_V))
    return float(high[0] * (high[2] - low[2]) - (high[4] - low[4]))


def draw_curve(rng: np.random.Generator, stroke_um: float) -> Curve:
    """A ceramic without hysteresis for a bank scenario: a straight line bent by up to 4 % of the stroke."""
    bend_um = float(rng.uniform(0.0, 0.15)) * stroke_um
    v = np.linspace(-0.5, 1.5, 201)
    return Curve(-60.0, 1.2, tuple((stroke_um * v + bend_um * v * (1.0 - v)).tolist()))


def draw_hysteresis(rng: np.random.Generator, stroke_um: float, kind: float) -> Hysteresis:
    """Hysteresis of a bank scenario. kind, uniform in 0 .. 1: Preisach below 0.55, relays below 0.75, else Bouc-Wen."""
    density = Density(float(rng.uniform(25, 60)), float(rng.uniform(45, 75)), float(rng.uniform(5, 35)), 65.0)
    share = float(rng.uniform(0.25, 0.5))
    if kind < 0.55:
        return Preisach(density, share)
    if kind < 0.75:
        return Relays(density, share, count=400)
    return BoucWen(float(rng.uniform(0.04, 0.09)) * stroke_um, float(rng.uniform(10, 23)), float(rng.uniform(0.5, 0.8)))
