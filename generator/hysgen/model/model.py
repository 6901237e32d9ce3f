"""The model: a uniform partition of the displacement, one linear consequent per rule, and additive terms.

    y(k+1) = sum_l p_l(y(k)) (q_l1 y(k) + q_l2 v(k) + q_l3) + sum_j theta_j phi_j(k)

The first sum is Eq. (4) of the paper, complete. The regressors phi_j come from additive terms (package `terms`): they
depend on past inputs, auxiliary channels and time, but not on v(k), so the model is affine in v(k) and Eq. (11) inverts
it. v is the input u after the input blocks (package `path`: saturation, slew, delay); without blocks, v = u.
This package is float64: the reference for the errors of the float32 layers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen import upward
from hysgen.display import OWN, Displayed, Quantities, Summary
from hysgen.errors import ModelError
from hysgen.model import simulate
from hysgen.model.disturbances import Term
from hysgen.model.feedback import Feedback
from hysgen.model.intervals import Interval
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.names import fault_of_name
from hysgen.model.path import InputBlock, check_chain, path_range

Floats = NDArray[np.float64]

MOST_RULES = 64
"""Rules up to which fit, generate and verify end within two minutes; the time of a fit grows with their cube."""
MOST_TS_S = 1e6
"""Sampling period from which on nothing of a stage is sampled; in ns it is a whole number below 2^50."""

SCHEMA = "hysgen-model"
VERSION = 1


@dataclass(frozen=True)
class Grid:
    """Uniform partition of the antecedent, Eqs (6) and (7).

    c_l = y_min + (y_max - y_min)(l - 1)/(L - 1),   sigma = (y_max - y_min)/(L - 1)

    y_min_um, y_max_um: range of the displacement in um; rules: L >= 2.
    centres_range_um: first and last centre, if the range was restricted afterwards (`within`); None: y_min_um and
    y_max_um, as in Eq. (6).
    Raises ModelError if the range is empty or not between the centres, or the number of rules unsupported.
    """

    y_min_um: float
    y_max_um: float
    rules: int
    centres_range_um: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not 2 <= self.rules <= MOST_RULES:
            raise ModelError(f"rules: {self.rules} is not supported; choose 2 to {MOST_RULES}")
        if not (np.isfinite(self.y_min_um) and np.isfinite(self.y_max_um) and self.y_min_um < self.y_max_um):
            raise ModelError(f"grid: the range {self.y_min_um} .. {self.y_max_um} um is empty; y_min must be below")
        first, last = self.ends_um
        if not first <= self.y_min_um < self.y_max_um <= last:
            raise ModelError(
                f"grid: the range {self.y_min_um:.6g} .. {self.y_max_um:.6g} um is not inside that of the rules, "
                f"{first:.6g} .. {last:.6g} um; choose a part of it"
            )

    @property
    def ends_um(self) -> tuple[float, float]:
        """The first and the last centre."""
        return (self.y_min_um, self.y_max_um) if self.centres_range_um is None else self.centres_range_um

    @property
    def step_um(self) -> float:
        """Distance of neighbouring centres; equal to sigma on this partition, Eq. (7)."""
        first, last = self.ends_um
        return (last - first) / (self.rules - 1)

    @property
    def centres_um(self) -> Floats:
        """(L,) centres of the memberships, Eq. (6)."""
        return self.ends_um[0] + self.step_um * np.arange(self.rules, dtype=np.float64)

    @property
    def places(self) -> tuple[float, float]:
        """The ends of the range in steps from the first centre: 0 and L - 1 if it was not restricted."""
        if self.centres_range_um is None:
            return 0.0, self.rules - 1.0
        first, step = self.centres_range_um[0], self.step_um
        return (self.y_min_um - first) / step, (self.y_max_um - first) / step

    def within(self, low_um: float, high_um: float) -> Grid:
        """The same rules over a part of the range. Raises ModelError if low_um .. high_um is not a part of it."""
        if not self.y_min_um <= low_um < high_um <= self.y_max_um:
            raise ModelError(
                f"displacement range: {low_um:.6g} .. {high_um:.6g} um is no part of the model's "
                f"{self.y_min_um:.6g} .. {self.y_max_um:.6g} um; choose a part of it"
            )
        return Grid(low_um, high_um, self.rules, self.ends_um)

    def clamp(self, y_um: Floats) -> Floats:
        """`y_um` limited to the range."""
        return np.clip(y_um, self.y_min_um, self.y_max_um)


@dataclass(frozen=True, repr=False, eq=False)
class Model(Displayed):
    """A Takagi-Sugeno hysteresis model with additive terms and input blocks.

    consequents: (L, 3), columns q_l1 [um/um], q_l2 [um/V], q_l3 [um].
    weights: (T,) theta_j of the terms' regressors, in the order of `terms`.
    u_min_V, u_max_V: input range of model and certificates; inputs outside are clamped.
    blocks: input blocks between the command and the stage, in the order of the signal.
    learner: settings of the generated learner; None generates no learner.
    feedback: the loop around the inverse; None generates none.
    quantities: what u_V and y_um are, if not a voltage and a displacement.
    history: origin (fit settings, record digest); scores: measured errors; certificates: guarantees. Plain JSON values.
    Raises ModelError if sizes disagree or a number is not finite.
    """

    name: str
    Ts_s: float
    grid: Grid
    consequents: Floats
    u_min_V: float
    u_max_V: float
    terms: tuple[Term, ...] = ()
    weights: Floats = field(default_factory=lambda: np.zeros(0))
    blocks: tuple[InputBlock, ...] = ()
    learner: LearnerSettings | None = None
    feedback: Feedback | None = None
    quantities: Quantities = OWN
    history: Mapping[str, Any] = field(default_factory=dict)
    scores: Mapping[str, Any] = field(default_factory=dict)
    certificates: Mapping[str, Any] = field(default_factory=dict)

    def __deepcopy__(self, made: dict[int, Any]) -> Model:
        """Itself, for it cannot change: mirrors are copied often."""
        return self

    def __post_init__(self) -> None:
        if fault := fault_of_name(self.name):
            raise ModelError(fault)
        if self.consequents.shape != (self.grid.rules, 3):
            raise ModelError(
                f"consequents: shape {self.consequents.shape} does not fit {self.grid.rules} rules; "
                f"expected ({self.grid.rules}, 3)"
            )
        size = sum(term.size for term in self.terms)
        if self.weights.shape != (size,):
            raise ModelError(f"weights: {self.weights.size} given, but the terms have {size} regressors")
        if not (np.isfinite(self.consequents).all() and np.isfinite(self.weights).all()):
            raise ModelError("parameters: not all finite; fit the model again")
        if not 0 < self.Ts_s < MOST_TS_S:
            raise ModelError(f"Ts_s: {self.Ts_s} is not a sampling period; it must be positive, in seconds")
        if not self.u_min_V < self.u_max_V:
            raise ModelError(f"input range: {self.u_min_V} .. {self.u_max_V} V is empty; u_min must lie below u_max")
        check_chain(self.blocks)
        kinds = [term.kind for term in self.terms]
        if len(set(kinds)) != len(kinds):
            raise ModelError(f"terms: {', '.join(kinds)}: a kind of term may stand once in a model")

    def summary(self) -> Summary:
        """Structure, ranges, terms and blocks."""
        grid = self.grid
        rows = [
            ["rules", f"{grid.rules} over {grid.y_min_um:.4g} .. {grid.y_max_um:.4g} um"],
            ["input", f"{self.u_min_V:.4g} .. {self.u_max_V:.4g} V"],
            ["sampling period", f"{1e6 * self.Ts_s:.6g} us"],
            *([f"input {block.kind}", block.describe()] for block in self.blocks),
            *([f"term {term.kind}", term.describe()] for term in self.terms),
            ["learner", "none" if self.learner is None else f"forgetting {self.learner.forgetting:.9g}"],
        ]
        kinds = ", ".join(["rules", *(term.kind for term in self.terms), *(block.kind for block in self.blocks)])
        return Summary(f"Model {self.name}: {kinds}, {self.parameters.size} parameters", ["part", "what"], rows, left=2)

    def __eq__(self, other: object) -> bool:
        """Whether all parts are equal, to the bit; names, scores and history too."""
        if not isinstance(other, Model):
            return NotImplemented
        pairs = ((getattr(self, part.name), getattr(other, part.name)) for part in dataclasses.fields(self))
        return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in pairs)

    def __hash__(self) -> int:
        numbers = (self.consequents.tobytes(), self.weights.tobytes())
        return hash((self.name, self.Ts_s, self.grid, self.u_min_V, self.u_max_V, self.blocks, self.terms, numbers))

    def to_json(self) -> dict[str, Any]:
        """The content of the model file as plain JSON values, in the order of the file."""
        centres, q = self.grid.centres_range_um, self.quantities
        return {
            "schema": SCHEMA,
            "version": VERSION,
            "name": self.name,
            "units": {"time": "s", q.input: q.input_unit, q.output: q.output_unit},
            "Ts_s": float(self.Ts_s),
            "grid": {
                "y_min_um": float(self.grid.y_min_um),
                "y_max_um": float(self.grid.y_max_um),
                "rules": int(self.grid.rules),
                **({} if centres is None else {"spread_um": [float(end) for end in centres]}),
            },
            "input_range_V": [float(self.u_min_V), float(self.u_max_V)],
            "consequents": self.consequents.tolist(),
            "terms": [term.to_json() for term in self.terms],
            "weights": self.weights.tolist(),
            "blocks": [block.to_json() for block in self.blocks],
            **({} if self.learner is None else {"learner": self.learner.to_json()}),
            **({} if self.feedback is None else {"feedback": self.feedback.to_json()}),
            "history": dict(self.history),
            "scores": q.json(dict(self.scores)),
            "certificates": q.json(dict(self.certificates)),
        }

    def simulate(
        self, u_V: ArrayLike, y0_um: float | None = None, channels: Mapping[str, ArrayLike] | None = None
    ) -> Floats:
        """Displacement in um, (n,), of a free run under the voltages u_V, (n,), from rest under u(0) or from y0_um."""
        return simulate.simulated_array(self, u_V, y0_um, channels)

    def predict(self, y_um: ArrayLike, u_V: ArrayLike, channels: Mapping[str, ArrayLike] | None = None) -> Floats:
        """One step ahead in um, (n,): element k predicts y(k) from measured y(k-1) and u(k-1); element 0 is y(0)."""
        return simulate.predicted_array(self, y_um, u_V, channels)

    def inverse(self, reference_um: ArrayLike, y_um: ArrayLike | None = None) -> Floats:
        """Voltage in V, (n - 1,), that takes y(k) to reference(k + 1), Eq. (11), in float32 by the generated C.

        y_um: measured displacement; by default the reference itself (feed-forward).
        """
        run: Floats = upward.inverse()(self, reference_um, y_um)
        return run

    def within(
        self, displacement_um: tuple[float, float] | None = None, input_V: tuple[float, float] | None = None
    ) -> Model:
        """The same model over a part of its ranges, without scores and certificates; None keeps a range.

        Raises ModelError if a range is not a part of the model's.
        """
        low_V, high_V = (self.u_min_V, self.u_max_V) if input_V is None else input_V
        if not self.u_min_V <= low_V < high_V <= self.u_max_V:
            raise ModelError(
                f"input range: {low_V:.6g} .. {high_V:.6g} V is no part of the model's "
                f"{self.u_min_V:.6g} .. {self.u_max_V:.6g} V; choose a part of it"
            )
        grid = self.grid if displacement_um is None else self.grid.within(*displacement_um)
        return dataclasses.replace(self, grid=grid, u_min_V=low_V, u_max_V=high_V, scores={}, certificates={})

    def raised(self, level_um: float) -> Model:
        """The model of a displacement that stands `level_um` higher, without scores and certificates.

            c_l + level,   q_l3 + level (1 - q_l1)

        Exact, because the memberships add up to 1. The path, whose output is a displacement less the level, stays.
        """
        grid = self.grid
        ends = grid.centres_range_um
        higher = Grid(
            grid.y_min_um + level_um,
            grid.y_max_um + level_um,
            grid.rules,
            None if ends is None else (ends[0] + level_um, ends[1] + level_um),
        )
        consequents = self.consequents.copy()
        consequents[:, 2] += level_um * (1.0 - consequents[:, 0])
        return dataclasses.replace(self, grid=higher, consequents=consequents, scores={}, certificates={})

    @property
    def rises(self) -> bool:
        """Whether a higher voltage raises the displacement."""
        slopes = [float(getattr(block, "mean_slope", 1.0)) for block in self.blocks]
        return float(np.prod(np.sign([*slopes, self.consequents[:, 1].sum()]))) >= 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """The auxiliary channels that terms and blocks read, each once, in the order of the C interface."""
        return tuple(dict.fromkeys(name for part in (*self.terms, *self.blocks) for name in part.channels))

    @property
    def responds(self) -> bool:
        """Whether the path holds a response of the stage (hysteresis, creep, modes)."""
        return any(block.responds for block in self.blocks)

    @property
    def w_unit(self) -> str:
        """Unit of w: um behind a hysteresis, V otherwise."""
        return next((block.unit for block in self.blocks if block.unit), "V")

    @property
    def w_range(self) -> Interval:
        """Range of w, the input of the rules behind all blocks, see `path_range`."""
        return path_range(self.blocks, Interval(self.u_min_V, self.u_max_V))

    @property
    def behind_path(self) -> Model:
        """The rules and terms alone, with w as their input."""
        w = self.w_range
        return dataclasses.replace(self, blocks=(), u_min_V=w.low, u_max_V=w.high, scores={}, certificates={})

    @property
    def parameters(self) -> Floats:
        """(3 L + T,) all linear parameters in the order of Eq. (9): q_11, q_12, q_13, q_21, ..., then the weights."""
        return np.concatenate([self.consequents.ravel(), self.weights])

    def with_parameters(self, parameters: Floats) -> Model:
        """The same structure with other parameters, without scores and certificates."""
        cut = 3 * self.grid.rules
        return dataclasses.replace(
            self,
            consequents=parameters[:cut].reshape(-1, 3).copy(),
            weights=parameters[cut:].copy(),
            scores={},
            certificates={},
        )
