"""A diagnosis with its record and its error maps on the held-out rows; for studies, its names alone."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.diagnosis.answer import Diagnosis, NamedCause
from hysgen.diagnosis.causes import Estimate, causes
from hysgen.diagnosis.causes.hysteresis import FOLLOWS
from hysgen.diagnosis.error_map import ErrorMap, error_map
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import fit_ladder, with_best_forms
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.procedure import DiagnoseSettings, Naming, Progress, diagnose, extended, name_causes
from hysgen.diagnosis.remedy import Advice, Seen, Sketch
from hysgen.display import Displayed, Summary
from hysgen.fitting import FitSettings
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen.record.relation import unrelated

__all__ = [
    "Estimate",
    "Extension",
    "Naming",
    "Prepared",
    "extended",
    "free_run_error",
    "name_causes",
    "prepare",
]


Floats = NDArray[np.float64]

SEEN_SHARE = 0.005
"""Share of the error's power below which a cause alone makes no difference that three digits show."""

LADDER = (
    "step",
    "free run um",
    "of stroke",
    "own um",
    "gain um, 95 %",
    "of the error",
    "cycles",
    "bytes",
    "confidence",
)
"""Column heads of `Study.ladder`."""


@dataclass(frozen=True)
class Remedy:
    """Advice on a named cause, what it would gain in words, and its small pictures if there are any."""

    name: str
    advice: Advice
    gain: str
    sketch: Sketch | None


@dataclass(frozen=True)
class HeldOut:
    """The longest part of a segment that is held out; every array is (n,).

    base_um, extended_um: free run of the base and of the extended model. `extended_um` includes the ramp or the change
    of gain that the diagnosis identified.
    """

    t_s: Floats
    u_V: Floats
    measured_um: Floats
    base_um: Floats
    extended_um: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Study(Displayed):
    """A diagnosis, its record, and the error maps before and after the extension.

    record: identification and held-out part joined; cut: first row of the held-out part.
    before, after: error map of the base and of the extended model on the held-out rows.
    span_um: range of the displacement over the whole record, the reference of percentages.
    """

    diagnosis: Diagnosis
    record: Record
    cut: int
    before: ErrorMap
    after: ErrorMap
    span_um: float

    @property
    def model(self) -> Model:
        """The extended model."""
        return self.diagnosis.model

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the causes, `unknown` last if structure is left."""
        return self.diagnosis.names

    def summary(self) -> Summary:
        """The ladder, the evidence of each cause, and the certificates that the extended model lacks."""
        diagnosis = self.diagnosis
        named = ", ".join(self.names) or "no cause"
        notes = [f"{cause.name}: {cause.evidence}" for cause in diagnosis.causes]
        reasons = [cause.why_not_extended for cause in diagnosis.causes]
        notes += [reason for reason in reasons if reason]
        if diagnosis.missing_certificates:
            notes.append(f"not certified in the extended model: {', '.join(diagnosis.missing_certificates)}")
        notes += [f"could show {one.name}: {one.text()}" for one in diagnosis.abilities if one.verdict != "named"]
        notes += [f"unknown: {diagnosis.unknown}"] if diagnosis.unknown else []
        notes.append(diagnosis.remaining.line())
        notes += [f"next experiment: {diagnosis.next_experiment}"] if diagnosis.next_experiment else []
        return Summary(f"Diagnosis of {self.record.source}: {named}", LADDER, self.ladder(), notes)

    def ladder(self) -> list[list[str]]:
        """The ladder as cells, columns LADDER: the paper's model, one row per extension in the model, the noise floor.

        The free-run errors are held out. Shown by the terminal, by notebooks and by the report.
        """
        diagnosis = self.diagnosis
        rows = [["paper's model", *self._size(diagnosis.base_rms_um), f"{diagnosis.base_own_um:.4g}", *[""] * 5]]
        for cause in self.extended:
            price = cause.price
            rows.append(
                [
                    f"+ {cause.name}",
                    *self._size(cause.cold_um[1]),
                    f"{cause.step.after_um:.4g}",
                    f"{cause.step.low_um:.3g} .. {cause.step.high_um:.3g}",
                    share_text(cause),
                    f"{price.cycles:+}" if price and price.cycles else "",
                    f"{price.bytes:+}" if price and price.bytes else "",
                    confidence_text(cause),
                ]
            )
        return [*rows, ["noise floor", *self._size(diagnosis.noise.rms_um), *[""] * 6]]

    @property
    def follows_voltage(self) -> bool:
        """Whether the displacement follows the voltage (`record.relation`): else no model is one of the stage."""
        return unrelated(self.record.segments) is None and not self.lines_prevail

    @property
    def lines_prevail(self) -> bool:
        """Whether less of the displacement follows the voltage than that of a drive that is measured does."""
        return self.of_lines > 1.0 - FOLLOWS

    @property
    def of_lines(self) -> float:
        """Share of the power of the displacement that lines hold, which do not depend on the voltage."""
        named = {cause.name: cause.parameters for cause in self.diagnosis.causes}.get("periodic", {})
        sizes_um = [size.value for key, size in named.items() if key.startswith("amplitude")]
        y_um = self.record.y_um
        return 0.5 * math.fsum(size * size for size in sizes_um) / float(y_um.var())

    @property
    def improved(self) -> bool:
        """Whether the extended model differs from the base."""
        return bool(self.extended)

    @property
    def extended(self) -> tuple[NamedCause, ...]:
        """The named causes whose extension is in the model, in the order of the ladder."""
        return tuple(cause for cause in self.diagnosis.causes if cause.extended)

    def percent(self, rms_um: float) -> float:
        """An error as a percentage of the span."""
        return 100.0 * rms_um / self.span_um

    def _size(self, rms_um: float) -> tuple[str, str]:
        """An error in um, and as a percentage of the span."""
        return f"{rms_um:.4g}", f"{self.percent(rms_um):.2g} %"

    def held_out(self) -> HeldOut:
        """Measured and simulated displacement over held-out rows."""
        edges = np.cumsum([0, *(segment.samples for segment in self.record.segments)])
        rows = self.diagnosis.held_rows
        parts = [rows[(rows >= low) & (rows < high)] for low, high in itertools.pairwise(edges)]
        number = int(np.argmax([len(part) for part in parts]))
        segment, offset = self.record.segments[number], int(edges[number])
        chosen = slice(int(parts[number][0]), int(parts[number][-1]) + 1)
        inside = slice(chosen.start - offset, chosen.stop - offset)
        measured = segment.y_um[inside]
        base, extended = (self.diagnosis.errors_um[i][1][chosen] for i in (0, -1))
        time_s = segment.start_s + self.record.Ts_s * np.arange(inside.start, inside.stop, dtype=np.float64)
        return HeldOut(time_s, segment.u_V[inside], measured, measured + base, measured + extended)

    def remedies(self) -> list[Remedy]:
        """Advice on each named cause with known parameters, the largest share first, and on what no cause explains."""
        ranked = sorted(self.diagnosis.causes, key=lambda cause: -cause.share)
        named = [(cause.name, self.by_how_much(cause), cause.parameters) for cause in ranked if cause.parameters]
        named += [("unknown", "not known: no model has it", {})] if self.diagnosis.unknown else []
        remedies = []
        for name, gain, parameters in named:
            values = {key: estimate.value for key, estimate in parameters.items()}
            seen = Seen(values, self.model, self.span_um, self.diagnosis.noise.rms_um)
            if (advice := causes()[name].advice(seen)) is not None:
                remedies.append(Remedy(name, advice, gain, causes()[name].sketch(seen)))
        return remedies

    def by_how_much(self, cause: NamedCause) -> str:
        """What a stage without the cause would gain, of this record's own figures.

        sqrt(base^2 - share (base^2 - noise^2)) of the paper's model; beside all other extensions, on left-out rows
        """
        base_um, noise_um = self.diagnosis.base_rms_um, self.diagnosis.noise.rms_um
        without_um = math.sqrt(base_um**2 - cause.share * max(base_um**2 - noise_um**2, 0.0))
        said = []
        if cause.share >= SEEN_SHARE:
            said.append(f"cured alone, it takes the paper's model from {base_um:.3g} to {without_um:.3g} um")
        if cause.alone is not None:
            said.append(f"cured last, from {cause.alone.before_um:.3g} to {cause.alone.after_um:.3g} um")
        return "; ".join(said) or "not measured: the reading is wrong, not the stage"

    def to_json(self) -> dict[str, Any]:
        """The diagnosis, advice on its causes, and the error maps of the held-out rows as plain JSON values."""
        return self.diagnosis.to_json() | {
            "remedies": [
                {
                    "cause": remedy.name,
                    "means": remedy.advice.means,
                    "change": remedy.advice.change,
                    "gain": remedy.gain,
                }
                for remedy in self.remedies()
            ],
            "record": {
                "source": self.record.source,
                "digest": self.record.digest,
                "samples": self.record.samples,
                "identified_rows": [0, self.cut],
                "span_um": self.span_um,
                "follows_voltage": self.follows_voltage,
            },
            "error_of_base": self.before.to_json(),
            "error_of_extended": self.after.to_json(),
        }


def share_text(cause: NamedCause) -> str:
    """The share of the error's power that the extension of a cause removes, as text."""
    percent = 100.0 * cause.share
    return "< 0.1 %" if 0.0 < percent < 0.05 else f"{percent:.1f} %"


def confidence_text(cause: NamedCause) -> str:
    """The confidence of a cause as text, empty where no gain is measured."""
    return "" if cause.confidence is None else f"{cause.confidence:.3f}"


def diagnose_and_evaluate(
    record: Record,
    holdout: Record | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
) -> Study:
    """Diagnose a record and map its held-out errors. Raises RecordError or FitError with a message of one line."""
    chosen, level_um = settings or DiagnoseSettings(), record.level_um
    if not level_um:
        return evaluate(diagnose(record, holdout, chosen, progress), record, holdout, chosen.identify)
    lower = None if holdout is None else holdout.raised(-level_um)
    found = diagnose(record.raised(-level_um), lower, chosen, progress)
    digest = prepare(record, holdout, chosen.identify).identification().digest
    found = replace(found, base=_raised(found.base, level_um, digest), model=_raised(found.model, level_um, digest))
    return evaluate(found, record, holdout, chosen.identify)


def _raised(model: Model, level_um: float, digest: str) -> Model:
    """The model of a displacement that stands `level_um` higher, fitted to the record of this digest."""
    higher = model.raised(level_um)
    history = {**model.history, "record": {**model.history.get("record", {}), "digest": digest}}
    return replace(higher, history=history, certificates=certify(higher).to_json())


def evaluate(diagnosis: Diagnosis, record: Record, holdout: Record | None, identify: float) -> Study:
    """The diagnosis of these records with the error maps of its held-out rows."""
    prepared = prepare(record, holdout, identify)
    first, noise_um = int(diagnosis.held_rows[0]), diagnosis.noise.rms_um
    low_um, high_um = prepared.record.y_range_um
    base, extended = diagnosis.errors_um[0][1], diagnosis.errors_um[-1][1]
    return Study(
        diagnosis,
        prepared.record,
        prepared.cut,
        error_map(diagnosis.base, prepared.record, noise_um, base, first),
        error_map(diagnosis.model, prepared.record, noise_um, extended, first),
        max(high_um - low_um, math.ulp(1.0)),
    )


def free_run_error(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str] = (), *, forms: bool = False
) -> NDArray[np.float64]:
    """Error in um, (n,), of the free run of the model with the extensions of `names`, fitted as a diagnosis does.

    forms: choose the forms of the extensions by cross-validation first.
    """
    settings = FitSettings()
    chosen = with_best_forms(prepared, extensions, names, settings) if forms else extensions
    return fit_ladder(prepared, chosen, names, settings).error_um
