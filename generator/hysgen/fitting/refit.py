"""Re-identification: the structure of a model fitted to another record, and the differences between two models.

Kept: name, number of rules, terms and input blocks with their shapes, input range, fit and learner settings.
New: the displacement range (within the restricted range of the old model, if it was restricted), every linear
parameter, scores, certificates, and the integral of a loop where the margins need it. The generated C algorithm is
unchanged; only `<name>_params.h` changes.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hysgen.certify.certificates import SAMPLES_PER_PERIOD, certify, loop, steady_states
from hysgen.display import Displayed, Summary, table
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.refine import Progress
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.scores import Scores, score, score_identification
from hysgen.record import Record

WORSE, OVER_NOISE = 1.5, 1.4
"""A structure no longer fits if the error exceeds these multiples of the old error and of the noise floor: at 1.4, the
misfit has the power of the noise."""


LOOP_SHARE = 0.9
"""Share of the input range over which loops are compared."""


def refit(
    model: Model, record: Record, progress: Progress | None = None, same_range: bool = False
) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there.

    same_range: keep the old displacement range, unless the record exceeds it; needed for a parameter image for running
    firmware, whose partition is fixed.
    Raises ModelError if the model file lacks its fit settings, RecordError or FitError as `fit` does.
    """
    if abs(record.Ts_s - model.Ts_s) > 1e-4 * model.Ts_s:
        raise ModelError(
            f"{record.source}: sampled every {record.Ts_s:g} s, but {model.name} steps every {model.Ts_s:g} s; "
            "record at the model's rate, or fit a new model"
        )
    settings = settings_of(model)
    if same_range:
        old_um = (model.grid.y_min_um, model.grid.y_max_um)
        settings = dataclasses.replace(settings, margin=0.0, displacement_range_um=old_um)
    # The record may exceed the model's input range: the fit uses all of it, and the result is restricted again.
    driven_V = (min(model.u_min_V, record.u_range_V[0]), max(model.u_max_V, record.u_range_V[1]))
    again = fit(record, dataclasses.replace(settings, input_range_V=driven_V), progress=progress)
    for index, term in enumerate(model.terms):
        if term.follows_measurements:
            at = sum(other.size for other in model.terms[:index])
            terms = (*again.terms[:index], term, *again.terms[index:])
            again = dataclasses.replace(again, terms=terms, weights=np.insert(again.weights, at, 1.0))
    again = restricted_as(model, again)
    again = dataclasses.replace(again, learner=model.learner, certificates=certify(again).to_json())
    if model.feedback is not None:
        from hysgen.feedback.certificate import carried  # imports scipy.stats, which takes half a second

        again = carried(model, again)
    scores = score_identification(again, record)
    return dataclasses.replace(again, scores={"identification": scores.to_json()}), scores


def loop_line(old: Model, new: Model) -> str:
    """What became of the loop of `old` in the refitted model; "" without one."""
    if old.feedback is None:
        return ""
    if new.feedback is None:
        return f"{old.name}: its loop does not keep its margins around the new model and is left out: hysgen loop anew"
    share = 100.0 * new.feedback.integral / old.feedback.integral
    return f"{old.name}: its loop keeps its margins around the new model, with {share:.3g} % of its integral"


def restricted_as(old: Model, new: Model) -> Model:
    """`new` restricted to the input range of `old`, and to its displacement range if `old` was restricted.

    A limit of `new` that is narrower already is kept. A restricted model has no scores and no certificates.

    Raises ModelError if the ranges do not overlap.
    """
    low_V, high_V = max(old.u_min_V, new.u_min_V), min(old.u_max_V, new.u_max_V)
    low_um, high_um = new.grid.y_min_um, new.grid.y_max_um
    if old.grid.centres_range_um is not None:
        low_um, high_um = max(old.grid.y_min_um, low_um), min(old.grid.y_max_um, high_um)
    as_it_is = (new.grid.y_min_um, new.grid.y_max_um, new.u_min_V, new.u_max_V)
    if (low_um, high_um, low_V, high_V) == as_it_is:
        return new
    restricted = None if (low_um, high_um) == as_it_is[:2] else (low_um, high_um)
    return new.within(restricted, (low_V, high_V))


def structure_fits(old: Model, scores: Scores) -> tuple[bool, str]:
    """Whether a structure still fits, and one line of reasons.

    scores: of the refitted model on its own record. The structure fits if the free-run error, relative to the span,
    is at most WORSE times that of `old` on its identification record, or at most OVER_NOISE times the noise floor.
    """
    percent, noise_um = scores.free_run.of_span_percent, scores.noise.rms_um
    before = old.scores.get("identification", {}).get("free_run", {}).get("of_span_percent")
    if before is None:
        return (
            True,
            f"free run {percent:.3g} % of the stroke; the old model has no score of its own to compare with",
        )
    figures = f"free run {percent:.3g} % of the stroke, {before:.3g} % before, noise {noise_um:.3g} um"
    if percent <= WORSE * before or scores.free_run.e_rms_um <= OVER_NOISE * noise_um:
        return True, f"still fits ({figures})"
    return False, f"NO LONGER FITS ({figures})"


def settings_of(model: Model) -> FitSettings:
    """The settings that `model` was fitted with, including its structure. Raises ModelError if the file lacks them."""
    stored = model.history.get("fit")
    if not isinstance(stored, dict):
        raise ModelError(f"{model.name}: the model file does not say how it was fitted; fit a new model instead")
    known = {field.name for field in dataclasses.fields(FitSettings)}
    structure = {
        "name": model.name,
        "rules": model.grid.rules,
        "terms": tuple(term for term in model.terms if not term.follows_measurements),
        "blocks": tuple(block for block in model.blocks if not isinstance(block, Hysteresis)),
        "memory": None if stored.get("memory") is None else PathSize(**stored["memory"]),
        "input_range_V": (model.u_min_V, model.u_max_V),
    }
    return FitSettings(**({key: value for key, value in stored.items() if key in known} | structure))


SLOW, FAST = 0.01, 0.3
"""Frequencies of the compared loops, relative to the corner frequency of the old model's lag."""

LEVELS = 9
"""Voltages over the input range at which the steady states are compared."""


@dataclass(frozen=True)
class Change:
    """A property of two models, in its unit."""

    what: str
    unit: str
    old: float
    new: float

    @property
    def percent(self) -> float | None:
        """Relative change in percent, None where the old value is zero."""
        return 100.0 * (self.new - self.old) / abs(self.old) if self.old else None


@dataclass(frozen=True, repr=False)
class Comparison(Displayed):
    """Differences between two models.

    centres_um: centre of each rule in the old and in the new model; rules: change of q1, q2, q3 of each.
    scores: for each record (source, free-run rms of the old model, of the new one) in um.
    """

    old: str
    new: str
    changes: tuple[Change, ...]
    centres_um: tuple[tuple[float, float], ...]
    rules: tuple[tuple[float, float, float], ...]
    scores: tuple[tuple[str, float, float], ...]

    def summary(self) -> Summary:
        """Content of the display."""
        return Summary(f"{self.old} -> {self.new}", ["property", "old", "new", "change"], self._changed())

    def text(self, heading: str = "") -> str:
        """Two tables: physical properties and free-run errors, old and new; change of each rule's consequents.

        heading: what is compared, by default the names of both models.
        """
        rules = [
            [f"{number}", f"{before:.4g} -> {after:.4g}", *(f"{value:+.3g}" for value in rule)]
            for number, (rule, (before, after)) in enumerate(zip(self.rules, self.centres_um, strict=True), start=1)
        ]
        return "\n\n".join(
            [
                table([heading or f"{self.old} -> {self.new}", "old", "new", "change"], self._changed()),
                table(["rule", "centre [um]", "q1 [um/um]", "q2 [um/V]", "q3 [um]"], rules),
            ]
        )

    def _changed(self) -> list[list[str]]:
        """Rows of physical properties and of free-run errors: name with unit, old, new, change."""
        physics = [
            [
                f"{change.what} [{change.unit}]" if change.unit else change.what,
                f"{change.old:.5g}",
                f"{change.new:.5g}",
                "" if change.percent is None else f"{change.percent:+.1f} %",
            ]
            for change in self.changes
        ]
        errors = [
            [f"free run on {source} [um rms]", f"{before:.4g}", f"{after:.4g}", ""]
            for source, before, after in self.scores
        ]
        return physics + errors

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "old": self.old,
            "new": self.new,
            "changes": [dataclasses.asdict(change) | {"percent": change.percent} for change in self.changes],
            "centres_um": [list(pair) for pair in self.centres_um],
            "rules_change": [list(rule) for rule in self.rules],
            "free_run_rms_um": [{"record": s, "old": before, "new": after} for s, before, after in self.scores],
        }


def compare(old: Model, new: Model, records: Sequence[Record] = ()) -> Comparison:
    """The changes from `old` to `new`, and the free-run errors of both on every record.

    Raises ModelError if the structures differ.
    """
    if _shape(old) != _shape(new):
        raise ModelError(
            f"{old.name} and {new.name}: structures differ ({_structure(old)} against {_structure(new)}); "
            "score both on one record instead"
        )
    loops_Hz = loop_frequencies(old)
    changes = [
        Change("displacement, low end", "um", old.grid.y_min_um, new.grid.y_min_um),
        Change("displacement, high end", "um", old.grid.y_max_um, new.grid.y_max_um),
    ]
    changes += [
        Change(what, unit, before, after)
        for (what, unit, before), (_, _, after) in zip(physics(old, loops_Hz), physics(new, loops_Hz), strict=True)
    ]
    moved = new.consequents - old.consequents
    scores = [
        (record.source, score(old, record).free_run.e_rms_um, score(new, record).free_run.e_rms_um)
        for record in records
    ]
    centres = zip(old.grid.centres_um.tolist(), new.grid.centres_um.tolist(), strict=True)
    rules = tuple((a, b, c) for a, b, c in moved.tolist())
    return Comparison(old.name, new.name, tuple(changes), tuple(centres), rules, tuple(scores))


def physics(model: Model, loops_Hz: Sequence[float]) -> list[tuple[str, str, float]]:
    """(property, unit, value): gain and time constant at mid-range, y at the ends, loops, sums of weights."""
    low_V, high_V = model.u_min_V, model.u_max_V
    states = steady_states(model, np.linspace(low_V, high_V, LEVELS))
    middle = states[LEVELS // 2]
    found = [
        ("DC gain, mid-range", "um/V", middle.gain_um_per_V),
        ("time constant, mid-range", "ms", 1e3 * (middle.tau_s or 0.0)),
        ("at rest at the lowest input", "um", states[0].y_um),
        ("at rest at the highest input", "um", states[-1].y_um),
    ]
    for f_Hz in loops_Hz:
        width_um, gain_um_per_V = loop_width(model, f_Hz)
        found.append((f"loop width at {f_Hz:.3g} Hz, mean", "um", width_um))
        found.append((f"gain at {f_Hz:.3g} Hz", "um/V", gain_um_per_V))
    start = 0
    for term in model.terms:
        weights = model.weights[start : start + term.size]
        start += term.size
        found.append((f"{term.kind}: sum of its {term.size} weights", "", float(weights.sum())))
    return found


def loop_width(model: Model, f_Hz: float) -> tuple[float, float]:
    """Mean width in um of the loop under a sine of f_Hz over LOOP_SHARE of the input range, and its gain in um/V."""
    width_V = LOOP_SHARE * (model.u_max_V - model.u_min_V)
    closed = loop(model, f_Hz, 0.5 * (model.u_min_V + model.u_max_V), 0.5 * width_V)
    # The area is the integral of the opening over the range of the sine.
    return closed.area_umV / width_V, closed.span_um / width_V


def loop_frequencies(model: Model) -> list[float]:
    """Frequencies in Hz of a slow and a fast sine, both sampled at least SAMPLES_PER_PERIOD times per period."""
    states = steady_states(model, np.array([0.5 * (model.u_min_V + model.u_max_V)]))
    corner_Hz = 1.0 / (2.0 * np.pi * (states[0].tau_s or 10.0 * model.Ts_s))
    highest_Hz = 1.0 / (SAMPLES_PER_PERIOD * model.Ts_s)
    return [min(part * corner_Hz, part / FAST * highest_Hz) for part in (SLOW, FAST)]


def _shape(model: Model) -> tuple[int, list[tuple[str, int]], list[str]]:
    """What two models must share to be compared number by number: rules, (kind, size) of the terms, kinds of blocks."""
    terms = [(term.kind, term.size) for term in model.terms]
    return model.grid.rules, terms, [block.kind for block in model.blocks]


def _structure(model: Model) -> str:
    parts = [f"{term.kind} of {term.size}" for term in model.terms] + [block.kind for block in model.blocks]
    kinds = ", ".join(parts) or "no terms"
    return f"{model.grid.rules} rules, {kinds}"
