"""The uncertainty of a displacement that a model states: its free run against the true displacement of the stage.

The residual of held-out rows is the free run minus the readings. Its power, less that of the noise, is split into what
repeated visits of a level show (repeatability) and the rest (error of the model):

    u_model^2 = max(mean e^2 - noise^2 - repeatability^2, 0)

The error of the model is split by cause. With a_i(k) the change of the free run that the extension of cause i makes on
the held-out rows, and b_i the part of a_i that is orthogonal to a_1 .. a_(i-1), the part of the residual that still
follows the action of cause i is

    u_i^2 = (b_i' e)^2 / (n b_i' b_i)

a wrong amplitude of its extension. A cause that is named and not in the model has the power that its extension would
remove. The rest has no named cause. The split changes neither u_model nor its degrees of freedom, which are those of
independent samples (`gum.independent_samples`), shared in proportion to the variances.

A hold is a voltage that stays constant for HOLD_S or longer; its position is the mean of its last half. Two holds
repeat each other if both have the same voltage and the holds before both have the same voltage, too: other visits of a
level differ by the hysteresis of the stage. With y_ij the position of visit j of n_i that repeat each other,

    s^2 = sum_i sum_j (y_ij - mean_j y_ij)^2 / sum_i (n_i - 1)
"""

import itertools
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.evaluation import Study
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor
from hysgen.uncertainty.gum import Budget, Contribution, SensorUncertainty, independent_samples, rectangular

HOLD_S: Final = 0.01
"""Shortest hold: several time constants of the lag of a stage, and 20 samples at 2 kHz."""

FEWEST_SAMPLES: Final = 16
_SAME_LEVEL: Final = 1e-3
"""Voltages within this part of the range are one level."""


@dataclass(frozen=True)
class Hold:
    """One hold: voltage, mean position; from_V: voltage of the hold before, if any."""

    u_V: float
    y_um: float
    from_V: float | None


@dataclass(frozen=True)
class Repeatability:
    """spread_um: s above with `freedom` degrees of freedom, None if no visit repeats another."""

    spread_um: float | None
    freedom: int
    holds: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dict(vars(self))


def repeatability(record: Record) -> Repeatability:
    """The repeatability of the levels of a record."""
    held = holds(record)
    volts = [hold.u_V for hold in held]
    tolerance_V = max(_SAME_LEVEL * (max(volts) - min(volts)), 1e-9) if volts else 1e-9
    visits: dict[tuple[int, int], list[float]] = defaultdict(list)
    for hold in held:
        if hold.from_V is not None:
            visits[round(hold.from_V / tolerance_V), round(hold.u_V / tolerance_V)].append(hold.y_um)
    repeated = [np.asarray(y) for y in visits.values() if len(y) > 1]
    freedom = sum(y.size - 1 for y in repeated)
    power = sum(float(((y - y.mean()) ** 2).sum()) for y in repeated)
    return Repeatability(float(np.sqrt(power / freedom)) if freedom else None, freedom, len(held))


def holds(record: Record) -> list[Hold]:
    """Every hold of a record, in its order."""
    least = max(FEWEST_SAMPLES, round(HOLD_S / record.Ts_s))
    held: list[Hold] = []
    for segment in record.segments:
        last: float | None = None
        edges = np.flatnonzero(np.diff(segment.u_V)) + 1
        for start, stop in itertools.pairwise([0, *edges.tolist(), segment.samples]):
            if stop - start >= least:
                level = float(segment.u_V[start])
                held.append(Hold(level, float(segment.y_um[start + (stop - start) // 2 : stop].mean()), last))
                last = level
    return held


MEASURAND = "displacement that the model states for a sample (free run)"


@dataclass(frozen=True)
class Evidence:
    """The inputs of a budget. residual_um: (n,) free run minus reading, on rows without part in any fit.

    fitted: rows of the identification; parameters: numbers fitted to them. drift_um: largest change of the displacement
    since the record, None if unknown. actions_um: cause and a_i, (n,), in ladder order. left_um: cause that is not in
    the model and the error that its extension would remove.
    """

    residual_um: NDArray[np.float64]
    noise: NoiseFloor
    fitted: int
    parameters: int
    sensor: SensorUncertainty
    repeatability: Repeatability | None = None
    drift_um: float | None = None
    actions_um: tuple[tuple[str, NDArray[np.float64]], ...] = ()
    left_um: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Characterisation:
    """Budget, repeatability, and error that each extension removes. missing: contributions that are not known."""

    budget: Budget
    repeatability: Repeatability
    removed: tuple[tuple[str, float], ...]
    missing: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "budget": self.budget.to_json(),
            "repeatability": self.repeatability.to_json(),
            "removed_by_extension_um": dict(self.removed),
            "missing": list(self.missing),
        }

    def lines(self) -> list[str]:
        """The result as text."""
        budget = self.budget
        wide = max(len(c.name) for c in budget.contributions)
        degrees = "" if math.isinf(budget.freedom) else f", {budget.freedom:.0f} degrees of freedom"
        return [
            f"uncertainty of the {budget.measurand}: U = {budget.expanded_um:.3g} um "
            f"(k = {budget.factor:.3g}, {100 * budget.coverage:.0f} %{degrees}), u_c = {budget.combined_um:.3g} um",
            *(f"    {row[0]:<{wide}}  {row[1]}  {row[2]:>9} um  {row[4]:>7}  {row[5]}" for row in budget.rows()),
            *(f"    not known: {name}" for name in self.missing),
        ]


def budget(evidence: Evidence) -> Budget:
    """The budget of a simulated displacement."""
    e = evidence.residual_um
    power = float(np.mean(e**2))
    noise2 = min(evidence.noise.rms_um**2, power)
    seen = evidence.repeatability
    spread = seen.spread_um if seen is not None and seen.spread_um is not None else 0.0
    repeat2 = min(spread**2, power - noise2)
    fit_um = evidence.noise.rms_um * math.sqrt(evidence.parameters / max(1, evidence.fitted))
    contributions = [
        Contribution("sensor", evidence.sensor.standard_um, "B", evidence.sensor.source),
        Contribution(
            "noise", fit_um, "A",
            f"{evidence.noise.rms_um:.3g} um a reading; {evidence.parameters} parameters, {evidence.fitted} rows",
            float(max(1, evidence.fitted - evidence.parameters)),
        ),
    ]  # fmt: skip
    if repeat2 > 0.0 and seen is not None:
        about = f"levels that the record visits again, {seen.holds} holds"
        contributions.append(Contribution("repeatability", math.sqrt(repeat2), "A", about, float(max(1, seen.freedom))))
    contributions += _model_error(evidence, max(power - noise2 - repeat2, 0.0))
    if evidence.drift_um is not None:
        about = f"at most {evidence.drift_um:.3g} um since the record"
        contributions.append(rectangular("drift", evidence.drift_um, about))
    return Budget(MEASURAND, tuple(contributions))


def _model_error(evidence: Evidence, power: float) -> list[Contribution]:
    """The error of the model, of mean square `power`, by cause; the rest last."""
    e = evidence.residual_um
    freedom = max(1.0, independent_samples(e.tolist()) - 1.0)
    parts = error_by_cause(e, evidence.actions_um)
    about = dict.fromkeys(dict(parts), "still follows the action of its extension")
    parts += [(name, size_um**2) for name, size_um in evidence.left_um]
    about |= dict.fromkeys(dict(evidence.left_um), "named; its extension, not in the model, would remove it")
    total = sum(part for _, part in parts)
    scale = min(1.0, power / total) if total > 0.0 else 1.0
    source = f"held-out free run over {e.size} rows, less noise and repeatability"
    lines = [(f"model error, {name}", scale * part, about[name]) for name, part in parts]
    rest = ("model error, rest" if lines else "model error", max(power - scale * total, 0.0), source)
    return [
        Contribution(name, math.sqrt(part), "A", text, freedom * part / power if part > 0.0 else freedom)
        for name, part, text in (*lines, rest)
    ]


def error_by_cause(
    residual_um: NDArray[np.float64], actions_um: Sequence[tuple[str, NDArray[np.float64]]]
) -> list[tuple[str, float]]:
    """(cause, u_i^2): mean square of the part of the residual that follows an action; a shared part counts once."""
    rest = residual_um.astype(np.float64)
    before: list[NDArray[np.float64]] = []
    parts = []
    for name, action_um in actions_um:
        own = action_um.astype(np.float64)
        for unit in before:
            own = own - (unit @ own) * unit
        size = float(np.linalg.norm(own))
        follows = 0.0
        if size > 1e-9 * float(np.linalg.norm(action_um)):
            before.append(own / size)
            follows = float(before[-1] @ rest)
        parts.append((name, follows**2 / rest.size))
    return parts


def characterise(study: Study, sensor: SensorUncertainty, drift_um: float | None = None) -> Characterisation:
    """The budget of a diagnosed record, for its extended model."""
    diagnosis = study.diagnosis
    seen = repeatability(study.record)
    rows = diagnosis.held_rows
    model = diagnosis.model
    evidence = Evidence(
        residual_um=diagnosis.errors_um[-1][1][rows],
        noise=diagnosis.noise,
        fitted=study.cut,
        parameters=model.consequents.size + model.weights.size,
        sensor=sensor,
        repeatability=seen,
        drift_um=drift_um,
        actions_um=_actions(study, rows),
        left_um=_left(study),
    )
    missing = []
    if drift_um is None:
        missing.append("drift since the record: state --drift-since")
    if seen.spread_um is None:
        missing.append("repeatability: the record repeats no step between two levels")
    return Characterisation(budget(evidence), seen, _removed(study), tuple(missing))


def _actions(study: Study, rows: NDArray[np.intp]) -> tuple[tuple[str, NDArray[np.float64]], ...]:
    """(cause, change of the free run by its extension on the held-out rows), in ladder order."""
    errors = [error[rows] for _, error in study.diagnosis.errors_um]
    changes = (after - before for before, after in itertools.pairwise(errors))
    return tuple((cause.name, change) for cause, change in zip(study.extended, changes, strict=True))


def _left(study: Study) -> tuple[tuple[str, float], ...]:
    """(cause that is named and not in the model, error that its extension would remove beside the others)."""
    contributions = []
    for cause in study.diagnosis.causes:
        if not cause.extended and cause.alone is not None:
            removed = max(cause.alone.before_um**2 - cause.alone.after_um**2, 0.0)
            contributions.append((cause.name, math.sqrt(removed)))
    return tuple(contributions)


def _removed(study: Study) -> tuple[tuple[str, float], ...]:
    """(cause, error in um that its extension removes): the root of the difference of the powers before and after."""
    before = study.diagnosis.base_own_um
    contributions: Sequence[tuple[str, float]] = []
    for cause in study.extended:
        after = cause.step.after_um
        contributions = [*contributions, (cause.name, math.sqrt(max(before**2 - after**2, 0.0)))]
        before = after
    return tuple(contributions)
