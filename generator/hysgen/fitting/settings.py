"""Settings of a fit."""

import math
import numbers
from dataclasses import dataclass
from typing import Any, Literal, get_args

from hysgen.errors import FitError
from hysgen.fitting.least_squares import Weighting
from hysgen.fitting.operator import PathSize
from hysgen.model.disturbances import Term
from hysgen.model.names import fault_of_name
from hysgen.model.path import InputBlock
from hysgen.model.regression import Starts, Trust

Method = Literal["rls", "batch", "refined"]
REALS = ("forgetting", "alpha", "epsilon", "margin", "slope_limit")
STORED = ("method", "rules", *REALS[:4], "settle", "certified", "slope_limit", "iterations")
"""Settings that a model file holds, in their order; `memory` and `rising` follow."""


@dataclass(frozen=True)
class FitSettings:
    """How a model is fitted to a record; defaults are the paper's where it states them (section 4.1).

    name: the model's name, which prefixes its C functions. rules: L.
    method: "rls", Eq. (10) as printed; "batch", the least-squares optimum that Eq. (10) converges to; "refined", the
    batch optimum followed by Gauss-Newton steps through the simulation, which minimise the free-run error.
    forgetting: lambda; alpha: P(0) = alpha I, i.e. a prior of weight 1/alpha; epsilon: q(0) = epsilon [1, 1, ...].
    margin: part of the displacement range added to the grid at each end; the paper's is 0.
    input_range_V: inputs that the model is valid for; None: the range in the record.
    displacement_range_um: displacements that the grid covers in any case; None: the range in the record.
    terms: additive terms, fitted together with the rules. blocks: blocks of the path between command and rules, without
    the hysteresis. memory: size of the hysteresis of the path. With it, or with a block that responds (creep, modes), a
    path is fitted, behind which the rules start as one lag (`fitting.path`).
    past: voltage in V at which the stage rested before a segment, and how long before its first row in s it left that
    level; None: it rested where the segment starts. What creep goes on adding is not the model's.
    rising: whether the hysteresis of the path rises with the voltage after every past. One that may fall predicts
    alone: it has no inverse.
    lag_s: time constant from which this lag is searched; None: the best of several.
    settle: burn-in, the samples at the start of each segment that are simulated but not scored in the refinement,
    because the state of the terms before the record is unknown; None: samples have a reduced weight until the terms no
    longer depend on that state, but at most for a quarter of the segment (see `free_run`).
    certified: constrain "batch" and "refined" to the set of models whose certificates hold; "rls" is not constrained.
    slope_limit: the largest |df/dy| in that set. iterations: largest number of Gauss-Newton steps.

    Raises FitError naming the field if a value is out of its domain.
    """

    name: str = "stage"
    rules: int = 6
    method: Method = "refined"
    forgetting: float = 1.0
    alpha: float = 1e6
    epsilon: float = 0.0
    margin: float = 0.0
    input_range_V: tuple[float, float] | None = None
    displacement_range_um: tuple[float, float] | None = None
    terms: tuple[Term, ...] = ()
    blocks: tuple[InputBlock, ...] = ()
    memory: PathSize | None = None
    past: tuple[float, float] | None = None
    rising: bool = True
    lag_s: float | None = None
    settle: int | None = None
    certified: bool = True
    slope_limit: float = 0.999
    iterations: int = 40

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            raise FitError(f"method: {self.method!r} is unknown; choose one of {', '.join(get_args(Method))}")
        if fault := fault_of_name(self.name):
            raise FitError(fault)
        for field, kind in (("rules", "whole"), ("iterations", "whole"), *((one, "real") for one in REALS)):
            value = getattr(self, field)
            if not isinstance(value, numbers.Integral if kind == "whole" else numbers.Real):
                raise FitError(f"{field}: {value!r} is no number; give a {kind} one")
        if self.memory is not None and not isinstance(self.memory, PathSize):
            raise FitError(f"memory: {self.memory!r} is no size; give a PathSize, or None for no hysteresis")
        _demand(0.0 < self.forgetting <= 1.0, "forgetting", self.forgetting, "above 0 and at most 1")
        _demand(0.0 < self.alpha < math.inf, "alpha", self.alpha, "positive and finite")
        _demand(math.isfinite(self.epsilon), "epsilon", self.epsilon, "finite")
        _demand(0.0 <= self.margin <= 1.0, "margin", self.margin, "between 0 and 1 of the displacement range")
        _demand(0.0 < self.slope_limit < 1.0, "slope_limit", self.slope_limit, "between 0 and 1")
        _demand(self.iterations >= 1, "iterations", self.iterations, "at least 1")
        _demand(self.settle is None or self.settle >= 0, "settle", self.settle or 0, "at least 0 samples")

    @property
    def on_path(self) -> bool:
        """Whether a physical path is fitted."""
        return self.memory is not None or any(block.responds for block in self.blocks)

    def weighting(self, trust: Trust | None, starts: Starts | None) -> Weighting:
        """Forgetting and prior of these settings, with the weights of samples and the initial states of a record."""
        return Weighting(self.forgetting, self.alpha, self.epsilon, trust, starts)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; without terms and blocks, which the model itself contains; `rising` where it is not."""
        memory = None if self.memory is None else self.memory.to_json()
        stored = {name: getattr(self, name) for name in STORED} | {"memory": memory}
        return stored if self.rising else stored | {"rising": False}


def _demand(holds: bool, field: str, value: object, domain: str) -> None:
    if not holds:
        raise FitError(f"{field}: {value} is out of range; it must be {domain}")
