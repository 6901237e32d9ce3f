"""Settings of the generated learner: learned parameters, forgetting, and protections.

The learner runs Eq. (10) in UD-factorised form on the DSP (see docs/learning.md). Its settings are stored in the model
file, because the generated C contains them as constants.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from hysgen.errors import ModelError
from hysgen.model.intervals import LARGEST

GROUPS = ("slope", "gain", "offset")
"""Groups of parameters: q_l1, q_l2, q_l3 of every rule."""

BIAS = ("bias",)
"""A group of one parameter: a displacement added to every q_l3."""

LEARNED = {"rules": GROUPS, "gain": ("gain",), "bias": BIAS}
"""Common choices by name."""


@dataclass(frozen=True)
class LearnerSettings:
    """Settings of the on-line learner; a field that is None is derived from the model (see `learner_numbers`).

    learned: groups of parameters, out of GROUPS, or BIAS; all other parameters are constant, the weights of terms
        among them.
    forgetting: forgetting factor lambda in (0, 1]. alpha: P(0) = alpha I, as in Eq. (10), in units of the parameters.
    window: with forgetting = 1, number of updates without forgetting (least squares); from then on the forgetting
        factor is `sliding`, a sliding window.
    refresh: one update in this many restores the prior, which forgetting reduces.
    noise_um: rms noise of the displacement. dead_zone_um: with forgetting, smaller innovations cause no update.
    outlier_ratio: an innovation this many times the rms innovation is an outlier. outlier_run: after this many
        consecutive outliers, innovations are accepted again.
    step_um, limit_um: largest change of a parameter per update, and largest parameter, as contributions to y(k+1).
    rest_V: no update while the input is within rest_V of its mean over the last 5 ms (at 50 kHz); 0 disables it.
    settle: updates before the first comparison of the shadow with the reference parameters and with persistence.
    worse, lost: the shadow restarts if its rms error exceeds `worse` times that of the reference parameters, or `lost`
        times that of persistence, y(k+1) = y(k).
    mature: updates since the last restart before `_commit` accepts the shadow.
    gain_floor_um_per_V, slope_limit: lower bound of |b(y)| and upper bound of |df/dy| of committed parameters.
    points, points_per_call: displacements at which `_commit` checks these bounds, and how many of them per call.
    Raises ModelError if a value is outside its range.
    """

    learned: tuple[str, ...] = GROUPS
    forgetting: float = 0.999
    alpha: float = 1e-3
    window: int = 131072
    sliding: float = 0.9999
    refresh: int = 8
    noise_um: float = 0.0005
    dead_zone_um: float | None = None
    outlier_ratio: float = 8.0
    outlier_run: int = 8
    step_um: float | None = None
    limit_um: float | None = None
    rest_V: float | None = None
    settle: int = 8192
    worse: float = 1.1
    lost: float = 2.0
    mature: int = 1024
    gain_floor_um_per_V: float | None = None
    slope_limit: float | None = None
    points: int | None = None
    points_per_call: int = 1

    def __post_init__(self) -> None:
        if self.learned != BIAS and (
            not self.learned or [group for group in GROUPS if group in self.learned] != list(self.learned)
        ):
            known = f"{', '.join(GROUPS)} in this order, or bias alone"
            raise ModelError(f"learner: learned {', '.join(self.learned) or 'nothing'}: choose among {known}")
        for name in ("forgetting", "sliding"):
            _require(0.9 <= getattr(self, name) <= 1.0, name, getattr(self, name), "0.9 to 1")
        _require(self.sliding < 1.0, "sliding", self.sliding, "below 1: in float32 no memory is endless")
        _require(1e-6 <= self.alpha <= 1e8, "alpha", self.alpha, "1e-6 to 1e8")
        _require(1024 <= self.window <= 2**24, "window", self.window, "1024 to 2^24 updates")
        _require(2 <= self.refresh <= 64, "refresh", self.refresh, "2 to 64")
        _require(0.0 < self.noise_um < math.inf, "noise_um", self.noise_um, "above 0")
        _require(3.0 <= self.outlier_ratio <= 1e6, "outlier_ratio", self.outlier_ratio, "3 to 1e6")
        _require(2 <= self.outlier_run <= 1024, "outlier_run", self.outlier_run, "2 to 1024")
        _require(64 <= self.settle <= 2**24, "settle", self.settle, "64 to 2^24 updates")
        _require(1.0 < self.worse <= 1e3, "worse", self.worse, "above 1")
        _require(1.0 <= self.lost <= 1e3, "lost", self.lost, "1 to 1e3")
        _require(0 <= self.mature <= 2**24, "mature", self.mature, "0 to 2^24 updates")
        _require(self.points is None or 4 <= self.points <= 1024, "points", self.points, "4 to 1024")
        _require(1 <= self.points_per_call <= 64, "points_per_call", self.points_per_call, "1 to 64")
        for name in ("dead_zone_um", "rest_V"):
            value = getattr(self, name)
            _require(value is None or 0.0 <= value < math.inf, name, value, "0 or more")
        for name in ("step_um", "limit_um", "gain_floor_um_per_V"):
            value = getattr(self, name)
            _require(value is None or 0.0 < value < math.inf, name, value, "above 0")
        _require(self.slope_limit is None or 0.0 < self.slope_limit < 1.0, "slope_limit", self.slope_limit, "below 1")

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, exact."""
        return dataclasses.asdict(self) | {"learned": list(self.learned)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Inverse of to_json.

        Raises ModelError naming the field that is unknown, missing or malformed, and for two settings of earlier
        versions: learned weights of terms, and an update divided among several calls.
        """
        data = dict(data)
        calls = data.pop("calls_per_update", 1)
        if calls != 1:
            raise ModelError(f"learner: calls_per_update {calls}: every update is one call now; fit again without it")
        if "terms" in str(data.get("learned")):
            raise ModelError("learner: learned terms: weights of terms are constant now; fit again with --learn rules")
        fields = {field.name: field for field in dataclasses.fields(cls)}
        for name in (*data.keys() - fields.keys(), *fields.keys() - data.keys()):
            state = "is unknown" if name in data else "is missing"
            raise ModelError(f"learner: {name} {state}; write the model file with hysgen, do not edit it")
        values = {name: _read(name, fields[name].default, value) for name, value in data.items()}
        return cls(**values)


def _read(name: str, default: Any, value: Any) -> Any:
    """The value of a field, converted to the type of its default. Raises ModelError if it has another type."""
    if name == "learned" and isinstance(value, list) and all(isinstance(group, str) for group in value):
        return tuple(value)
    number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST
    if isinstance(default, int) and number and isinstance(value, int):
        return value
    if name == "points" and number and isinstance(value, int):
        return value
    if (isinstance(default, float) or (default is None and name != "points")) and number:
        return float(value)
    if default is None and value is None:
        return None
    raise ModelError(f"learner: {name}: {value!r} is not what this field holds; write the model file with hysgen")


def _require(holds: bool, name: str, value: object, valid: str) -> None:
    if not holds:
        raise ModelError(f"learner: {name} {value}: choose {valid}")
