"""What a fit is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, get_args

from hysgen.errors import FitError
from hysgen.model.path import InputBlock
from hysgen.model.terms import Term

Method = Literal["rls", "batch", "refined"]


@dataclass(frozen=True)
class FitSettings:
    """How a model is fitted to a record; the defaults are the paper's where it has them (section 4.1).

    name: the model's name, which prefixes its C functions. rules: L.
    method: "rls", Eq. (10) as printed; "batch", the least-squares optimum that it converges to; "refined", from there
    on Gauss-Newton steps through the simulation, which minimise the free-run error.
    forgetting: lambda; alpha: P(0) = alpha I, i.e. a prior of weight 1/alpha; epsilon: q(0) = epsilon [1, 1, ...].
    margin: part of the displacement range added to the grid at each end; the paper's is 0.
    input_range_V: for which the model is to answer; None: what the record holds.
    displacement_range_um: that the grid covers in any case; None: what the record holds.
    terms: extension terms, fitted together with the rules. blocks: what the input passes through before the stage.
    settle: samples at the start of each segment that are simulated but not scored in the refinement, because the state
    of the terms before the record is unknown; None: until the terms have forgotten it, but at most a quarter of the
    segment, samples count a little (see `free_run`).
    certified: keep "batch" and "refined" inside the set of models whose certificates hold; "rls" is never touched.
    slope_limit: the largest |df/dy| allowed then. loop_limit: the largest loop gain of the terms around the inverse; a
    learner that is to commit needs room below 1; inf: the model is to simulate and need have no inverse.
    iterations: most Gauss-Newton steps.

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
    settle: int | None = None
    certified: bool = True
    slope_limit: float = 0.999
    loop_limit: float = 0.95
    iterations: int = 40

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            raise FitError(f"method: {self.method!r} is unknown; choose one of {', '.join(get_args(Method))}")
        _demand(0.0 < self.forgetting <= 1.0, "forgetting", self.forgetting, "above 0 and at most 1")
        _demand(0.0 < self.alpha < math.inf, "alpha", self.alpha, "positive and finite")
        _demand(math.isfinite(self.epsilon), "epsilon", self.epsilon, "finite")
        _demand(0.0 <= self.margin <= 1.0, "margin", self.margin, "between 0 and 1 of the displacement range")
        _demand(0.0 < self.slope_limit < 1.0, "slope_limit", self.slope_limit, "between 0 and 1")
        open_ended = self.loop_limit == math.inf
        _demand(open_ended or 0.0 < self.loop_limit < 1.0, "loop_limit", self.loop_limit, "between 0 and 1, or inf")
        _demand(self.iterations >= 1, "iterations", self.iterations, "at least 1")
        _demand(self.settle is None or self.settle >= 0, "settle", self.settle or 0, "at least 0 samples")

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; terms and blocks stand in the model itself."""
        return {
            "method": self.method,
            "rules": self.rules,
            "forgetting": self.forgetting,
            "alpha": self.alpha,
            "epsilon": self.epsilon,
            "margin": self.margin,
            "settle": self.settle,
            "certified": self.certified,
            "slope_limit": self.slope_limit,
            "loop_limit": self.loop_limit if math.isfinite(self.loop_limit) else None,
            "iterations": self.iterations,
        }


def _demand(holds: bool, field: str, value: float, domain: str) -> None:
    if not holds:
        raise FitError(f"{field}: {value} is out of range; it must be {domain}")
