"""The diagnosis: split the record, fit the probe, name the causes, extend the model, score each rung of the ladder."""

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.answer import Diagnosis, NamedCause, Price, Refused, left_over
from hysgen.diagnosis.causes import Estimate, Residual, Signature, causes, in_ladder_order
from hysgen.diagnosis.experiment import Limits, in_words, lacking, with_time_for
from hysgen.diagnosis.extension import Correction, Extension
from hysgen.diagnosis.identifiability import Ability, abilities, unexplained_structure
from hysgen.diagnosis.ladder import (
    Gain,
    Rung,
    add_online_parts,
    checked_errors,
    combined_confidence,
    extensions_for,
    fit_ladder,
    gain,
    joint_shares,
    left_by,
    with_best_forms,
)
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.probe import rms
from hysgen.diagnosis.score import present
from hysgen.diagnosis.search import SearchResult, over_all_rows, search
from hysgen.fitting import FitSettings
from hysgen.machine.cache import forget, resumed, steps
from hysgen.machine.processes import in_processes, one_blas_thread, several_processes
from hysgen.model.model import Model
from hysgen.model.remaining import LEAST_EVIDENCE, Remaining
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor, noise_floor

Floats = NDArray[np.float64]
Progress = Callable[[float, str], None]

LEAST_CONFIDENCE = 0.7
"""Least share of bootstrap draws in which an extension that is made lowers the error on blocks left out of the fit by
LEAST_FALL. It decides what is worth its cycles; what is named does not depend on it."""

LEAST_FALL = 0.02
"""An extension that lowers the rms error by less than this share is not made: it does not pay for its cycles."""

SEARCHED = 0.7
"""Share of the time of `name_causes` until the search is done, for progress."""

SOURCES = Path(__file__).parents[1]
"""Folder of the code that a kept search depends on."""


@dataclass(frozen=True)
class DiagnoseSettings:
    """Settings of a diagnosis.

    fit: settings of the Takagi-Sugeno fits; their terms and blocks are replaced by those of the extensions.
    identify: share of a single record that is used for identification.
    resume: keep the fits of the search, which takes most of the time, until the diagnosis is done, so that an
    interrupted one goes on there.
    keep_all: make the extension of every named cause, also where it gains less than LEAST_FALL on blocks left out.
    price: function for the cycles and bytes of a model, None if unknown (`hysgen.report.words.price_of`).
    """

    fit: FitSettings = field(default_factory=FitSettings)
    identify: float = 0.65
    price: Callable[[Model], Price | None] | None = None
    keep_all: bool = False
    resume: bool = False


@dataclass(frozen=True, eq=False)
class Naming:
    """The named causes, before the models of the ladder are fitted.

    whole: residual of the probe over all rows of the identification part.
    agreed: named causes in ladder order: those of the chain with the least score, and `outliers`.
    unknown: description of structure that is left, or None. abilities: what the record can tell about every cause.
    """

    prepared: Prepared
    found: SearchResult
    whole: Residual
    signatures: dict[str, Signature]
    extensions: dict[str, Extension]
    agreed: list[str]
    noise: NoiseFloor
    unknown: str | None
    abilities: tuple[Ability, ...]
    next_experiment: str

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the causes, `unknown` last if structure is left."""
        return (*self.agreed, *(("unknown",) if self.unknown else ()))

    @property
    def confidence(self) -> dict[str, float]:
        """Confidence of every cause in the chain: that of the search, as far as the error of its amount leaves it."""
        most = {name: signature.most_confidence for name, signature in self.signatures.items()}
        return {name: min(self.found.confidence[name], most.get(name, 1.0)) for name in present(self.found.fit.chain)}

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Every parameter of the named causes, by "cause.parameter"."""
        return {
            f"{name}.{key}": estimate
            for name in self.agreed
            for key, estimate in self.signatures[name].parameters.items()
        }


@one_blas_thread()
@several_processes(__name__)
def diagnose(
    record: Record,
    holdout: Record | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """The causes of the simulation error of a stage, and the extended model with the gain of each extension.

    Structure and parameters are identified from the identification part alone; every score is of held-out rows.
    progress: called with the fraction done and one line of text.
    Raises RecordError or FitError with one line.
    """
    report = progress or (lambda fraction, line: None)
    naming = name_causes(record, holdout, settings, lambda fraction, line: report(0.7 * fraction, line))
    return extended(naming, settings, lambda fraction, line: report(0.7 + 0.3 * fraction, line))


@one_blas_thread()
@several_processes(__name__)
def extended(naming: Naming, settings: DiagnoseSettings | None = None, progress: Progress | None = None) -> Diagnosis:
    """The diagnosis with these causes: the model that they extend, and what it leaves of the held-out rows.

    Raises FitError with one line.
    """
    chosen = settings or DiagnoseSettings()
    report = progress or (lambda fraction, line: None)
    inputs = _inputs(naming.prepared)
    naming = dataclasses.replace(naming, prepared=naming.prepared.without(_unpredictable(naming)))
    report(0.0, "choosing the forms of the extensions")
    best = with_best_forms(naming.prepared, naming.extensions, naming.agreed, chosen.fit)
    naming = dataclasses.replace(naming, extensions=best)
    report(0.33, "measuring what each extension gains")
    made, alone = _worth_extending(naming, dataclasses.replace(chosen.fit, certified=True))
    made = list(naming.agreed) if chosen.keep_all else made
    report(0.5, "fitting rules, " + ", ".join(made))
    fit_rung = functools.partial(_rung, naming, chosen.fit)
    rungs = in_processes(fit_rung, [made[:count] for count in range(len(made) + 1)], cost=len)
    report(0.83, "measuring what is left of the held-out rows")
    scored = _scored(naming, alone, made, rungs, chosen)
    report(1.0, "done")
    if chosen.resume:
        forget(inputs, SOURCES)
    return scored


@one_blas_thread()
@several_processes(__name__)
def name_causes(
    record: Record,
    holdout: Record | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
) -> Naming:
    """The causes in the identification part with parameters and evidence; no model of the ladder is fitted.

    Raises RecordError or FitError with one line.
    """
    chosen = settings or DiagnoseSettings()
    report = progress or (lambda fraction, line: None)
    prepared = prepare(record, holdout, chosen.identify)
    report(0.05, "fitting the probe")

    fraction = 0.05

    def found_so_far(line: str) -> None:
        # The number of steps is unknown: each takes a quarter of what is left of the search's share.
        nonlocal fraction
        fraction += 0.25 * (SEARCHED - fraction)
        report(fraction, line)

    def searched() -> SearchResult:
        scene = prepared.excerpt()
        return search(
            dataclasses.replace(scene, kept=steps(_inputs(prepared), SOURCES)) if chosen.resume else scene, found_so_far
        )

    found = resumed(_inputs(prepared), SOURCES, searched) if chosen.resume else searched()
    report(SEARCHED, "weighing the evidence")
    whole = over_all_rows(found, prepared.scene())
    signatures = _signatures(found, whole)
    agreed = in_ladder_order(name for name in signatures if causes()[name].extends)
    able = abilities(found.residual, whole, signatures)
    lacks = lacking(prepared.u_V[: prepared.cut], [ability.lacks for ability in able])
    limits = with_time_for(lacks, Limits.of(prepared.u_V[: prepared.cut], prepared.record.Ts_s))
    return Naming(
        prepared,
        dataclasses.replace(found, scene=found.scene.bare()),  # its columns are no longer needed
        whole,
        signatures,
        _extensions(found, whole, agreed),
        agreed,
        noise_floor(record),
        _unknown(signatures, unexplained_structure(prepared, whole, noise_floor(prepared.identification()))),
        able,
        in_words(lacks, limits),
    )


def _unknown(signatures: Mapping[str, Signature], left: str | None) -> str | None:
    """What no model can be extended by, in words: the named causes of this kind and the structure that is left."""
    words = [signature.text for name, signature in signatures.items() if not causes()[name].extends]
    return "; ".join([*words, *([left] if left else [])]) or None


def _unpredictable(naming: Naming) -> list[Correction]:
    """The changes of the displacement that no model predicts: every model is fitted and scored without them."""
    extensions = [
        causes()[name].extension(naming.found.residual) for name in naming.signatures if not causes()[name].extends
    ]
    return [extension.correction for extension in extensions if extension.correction is not None]


def _inputs(prepared: Prepared) -> tuple[str, ...]:
    """What a search depends on."""
    return ("search", prepared.record.digest, str(prepared.cut))


def _signatures(found: SearchResult, whole: Residual) -> dict[str, Signature]:
    """The signature of each cause in the final fit (`Cause.shown`)."""
    searched = Residual(found.scene, found.fit, found.corrupted)
    residuals = {name: whole if cause.on_all_rows else searched for name, cause in causes().items()}
    return {
        name: cause.signature(residuals[name], found.rivals.get(name, found.fit))
        for name, cause in causes().items()
        if cause.shown(residuals[name])
    }


def _extensions(found: SearchResult, whole: Residual, names: Sequence[str]) -> dict[str, Extension]:
    """The extension of each cause with the parameters of the final chain."""
    return {name: causes()[name].extension(whole if causes()[name].on_all_rows else found.residual) for name in names}


def _rung(naming: Naming, settings: FitSettings, names: Sequence[str]) -> Rung:
    """The rung of the ladder with the extensions of `names`."""
    return fit_ladder(naming.prepared, _extensions_for(naming, names), names, settings)


def _extensions_for(naming: Naming, names: Sequence[str]) -> dict[str, Extension]:
    return extensions_for(naming.found, naming.extensions, names)


def _worth_extending(naming: Naming, settings: FitSettings) -> tuple[list[str], dict[str, Gain]]:
    """The named causes whose extensions lower the error of the model, and the gain of each extension beside the others.

    Each round leaves out the extension with the least confidence until all have at least LEAST_CONFIDENCE. Among equal
    confidences, the extension is left out without which the error is smallest. The gain of such an extension is the one
    beside the extensions of its round.
    """
    kept, gains = list(naming.agreed), dict[str, Gain]()
    while True:
        alone = _gains_beside_others(naming.prepared, naming.whole, naming.extensions, kept, settings)
        gains |= alone
        worst = min(alone, key=lambda name: (alone[name].confidence, alone[name].before_um), default=None)
        if worst is None or alone[worst].confidence >= LEAST_CONFIDENCE:
            return kept, gains
        kept.remove(worst)


def _gains_beside_others(
    prepared: Prepared,
    whole: Residual,
    extensions: dict[str, Extension],
    names: list[str],
    settings: FitSettings,
) -> dict[str, Gain]:
    """Gain of the extension of each cause beside all others, on blocks left out of the fit.

    The result omits causes that are not judged by their gain (`Cause.judged_by_gain`).
    """
    judged = [name for name in names if causes()[name].judged_by_gain]
    if not judged:
        return {}
    sets = [list(names), *([other for other in names if other != name] for name in judged)]
    checked = checked_errors(prepared, [(extensions, chosen) for chosen in sets], settings)
    rows, whole_um = checked[0]
    clean = ~whole.corrupted[rows] if len(whole.corrupted) else np.ones(len(rows), dtype=bool)
    gains = {}
    for name, (_, without_um) in zip(judged, checked[1:], strict=True):
        sure = combined_confidence(without_um[clean], whole_um[clean], LEAST_FALL)
        gains[name] = dataclasses.replace(gain(without_um[clean], whole_um[clean]), confidence=sure)
    return gains


def _scored(
    naming: Naming, alone: dict[str, Gain], made: list[str], rungs: Sequence[Rung], settings: DiagnoseSettings
) -> Diagnosis:
    """The diagnosis with all scores on held-out rows. alone: of `_worth_extending`."""
    prepared, noise, agreed = naming.prepared, naming.noise, naming.agreed
    held = prepared.held_rows
    last = _left(naming, rungs[-1], None)
    # Wrong readings and sudden changes of the record are those that the last rung shows.
    others = (np.concatenate(_left(naming, rung, last).error_um) for rung in rungs[:-1])
    own_um = [*others, np.concatenate(last.error_um)]
    gates = [any(naming.extensions[name].gate for name in rung.causes) for rung in rungs]
    clean = np.flatnonzero(np.concatenate(last.counted))
    cold = [rms(rung.error_um[clean if gate else held]) for rung, gate in zip(rungs, gates, strict=True)]
    # Wrong readings count until a rung rejects them.
    rows = [clean if gate or not any(gates) else held for gate in gates]
    levels = [rms(error[chosen]) for error, chosen in zip(own_um, rows, strict=True)]
    removed = [alone[name].before_um ** 2 - alone[name].after_um ** 2 if name in alone else 0.0 for name in made]
    parts, rest = joint_shares([level**2 for level in levels], noise.rms_um**2, removed)
    shares = dict(zip(made, parts, strict=True))
    span_s = naming.found.scene.span_s
    running = [
        add_online_parts(rung.model, [extensions[name] for name in rung.causes], span_s, noise.rms_um)
        for rung, extensions in ((rung, _extensions_for(naming, rung.causes)) for rung in rungs)
    ]
    price = settings.price
    prices = (
        in_processes(price, running, cost=lambda model: len(model.blocks))
        if price is not None
        else [None] * len(running)
    )
    named, searched = [], naming.found.residual
    for name in agreed:
        # A cause without extension adds no rung.
        i = sum(other in made for other in agreed[: agreed.index(name)])
        j = i + (name in made)
        step = gain(own_um[i][clean], own_um[j][clean])
        step = dataclasses.replace(step, before_um=levels[i], after_um=levels[j])
        signature = naming.signatures[name]
        signature = causes()[name].seen_in(signature, running[-1], searched) if name in made else signature
        named.append(
            NamedCause(
                name=name,
                parameters=signature.parameters,
                evidence=signature.text,
                statistic=signature.z,
                step=step,
                alone=alone.get(name),
                cold_um=(cold[i], cold[j]),
                confidence=naming.confidence[name] if name in naming.found.bayes else None,
                bayes=naming.found.bayes.get(name),
                probe_gain=naming.found.error_growth.get(name),
                share=shares.get(name, 0.0),
                price=Price.between(prices[i], prices[j]) if name in made else None,
                extended=name in made,
            )
        )
    falling = dataclasses.replace(settings.fit, rising=False)
    steps = np.concatenate([np.diff(s.y_um, prepend=s.y_um[0]) for s in prepared.record.segments])
    return Diagnosis(
        causes=tuple(named),
        refused=tuple(
            Refused(name, f"the score falls by {fall:.1f} with it, and {LEAST_EVIDENCE:.1f} are required")
            for name, fall in naming.found.refused.items()
            if causes()[name].extends
        ),
        unknown=naming.unknown,
        base=rungs[0].model,
        model=running[-1],
        base_rms_um=cold[0],
        extended_rms_um=cold[-1],
        base_own_um=levels[0],
        remaining=left_over(
            prepared,
            naming.found.fit.chain,
            naming.extensions,
            last,
            noise.rms_um,
            "memory" in agreed,
            lambda: _left(naming, _rung(naming, falling, agreed), last),
        ),
        noise=noise,
        persistence_um=rms(steps[held]),
        unexplained_fraction=rest,
        abilities=naming.abilities,
        next_experiment=naming.next_experiment,
        errors_um=tuple((" + ".join(rung.causes) or "paper model", rung.error_um) for rung in rungs),
        held_rows=held,
        probe_rms_um=naming.whole.fit.rms_um,
    )


def _left(naming: Naming, rung: Rung, beside: Remaining | None) -> Remaining:
    extensions = _extensions_for(naming, rung.causes)
    return left_by(naming.prepared, {name: extensions[name] for name in rung.causes}, rung.error_um, beside)
