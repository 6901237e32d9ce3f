"""A diagnosis as text: verdict, output for the terminal, parameters with units; and the price of an extension."""

import math
from collections.abc import Sequence

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.codegen import Derived, cost_figures
from hysgen.codegen.operations import cycles_of, per_sample
from hysgen.diagnosis.answer import Price
from hysgen.diagnosis.causes import Estimate
from hysgen.diagnosis.error_map import range_in_words
from hysgen.diagnosis.evaluation import LADDER, Remedy, Study
from hysgen.display import decimal, table
from hysgen.errors import BudgetError, CertificateError
from hysgen.model.model import Model
from hysgen.record.relation import coherent_share, fed_back, misaligned, unrelated
from hysgen.report.sketches import dotted

UNITS = {
    "half_widths": "of each half-width per factor e of time",
    "um_per_decade": "um per decade",
    "um_per_unit": "um per unit",
    "um_per_s": "um/s",
    "V_per_s": "V/s",
    "per_decade": "per decade",
    "per_s": "1/s",
    "um": "um",
    "V": "V",
    "s": "s",
    "Hz": "Hz",
    "samples": "samples",
}
"""Unit by the end of a parameter's name, the longest first."""

COLD_AS_OWN = 1.05
"""Cold error over the model's own up to which the verdict states one of them."""

SMALLEST_SHARE = 0.005
"""Share of the error's power below which the verdict gives a cause no percentage of its own."""

FAR_ABOVE_NOISE = 5.0
"""Error over noise above which an answer without a cause lists the candidates that were refused."""

AS_A_CONSTANT = 0.9
"""Error over that of the mean from which on a model explains nothing: less than a fifth of the power."""

MOST_PLACES = 9
"""Decimal places above which a parameter is written with an exponent."""

CONFIDENCE = "confidence: posterior probability of the cause over all chains of causes that were compared"
"""What the column of that name holds."""


def diagnosis_text(study: Study) -> str:
    """A diagnosis for the terminal: verdict, ladder, evidence, error profiles, certificates, next experiment."""
    diagnosis = study.diagnosis
    blocks = [
        _rows_of(study),
        "\n".join(verdict(study)),
        table(LADDER, study.ladder()) + f"\nnoise floor from {diagnosis.noise.source}"
        "; own: without what no model can know\ngain: fall of own, block bootstrap; of the error: share of its power "
        "above the noise"
        + (f"\n{CONFIDENCE}" if study.extended else "")
        + "".join(f"\ntaken out of own: {taken.text}" for taken in diagnosis.remaining.taken),
    ]
    stated = {cause.name: parameter_text(study, cause.name) for cause in diagnosis.causes}
    evidence = [
        f"{cause.name}: {cause.evidence}" + (f" ({stated[cause.name]})" if stated[cause.name] else "")
        for cause in diagnosis.causes
    ]
    evidence += [f"not named: {refused.name}: {refused.why}" for refused in diagnosis.refused]
    evidence += [
        f"could show {ability.name}: {ability.text()}" for ability in diagnosis.abilities if ability.verdict != "named"
    ]
    if evidence:
        blocks.append("\n".join(evidence))
    blocks += [remedy_text(study, remedy) for remedy in study.remedies()]
    header = ["error rms by", "paper's model", *(["extended"] if study.improved else [])]
    blocks.append(table(header, where_rows(study), left=3))
    model = diagnosis.model
    parts = [f"{model.grid.rules} rules", *(part.kind for part in (*model.blocks, *model.terms))]
    blocks.append("\n".join([f"model: {', '.join(parts)}", *certify(model).lines()]))
    if diagnosis.next_experiment:
        blocks.append(f"next experiment: {diagnosis.next_experiment}")
    return "\n\n".join(blocks)


def remedy_text(study: Study, remedy: Remedy) -> str:
    """What to do about a cause, with its pictures where its share is more than SMALLEST_SHARE."""
    shares = {cause.name: cause.share for cause in study.diagnosis.causes}
    large = shares.get(remedy.name, 0.0) >= SMALLEST_SHARE
    lines = dotted(remedy.sketch, remedy.name) if large and remedy.sketch else []
    said = [f"means: {remedy.advice.means}", f"change: {remedy.advice.change}", f"gain: {remedy.gain}"]
    return "\n".join([f"what to do about {remedy.name}", *lines, *said])


def _rows_of(study: Study) -> str:
    """How many rows identify and how many score; of a held-out file, its first rows show what the stage remembers."""
    rows, held = study.record.samples - study.cut, study.diagnosis.held_rows
    scored = f"scores are of the {rows} held out"
    if int(held[0]) > study.cut:
        scored = (
            f"scores are of {held.size} of the {rows} held out: the first rows of a file depend on the input before "
            "it, which is unknown"
        )
    return f"{study.record.source}: {study.cut} rows to identify; {scored}"


def price_of(model: Model) -> Price | None:
    """Cycles per sample, and bytes of structs and constants, of the C that is generated for a model.

    cycles = max(predict, simulate, inverse), plus `learn` and `commit` for a model with a learner: the sum that
    `hysgen cost` states, estimated from operation counts (`hysgen.codegen.operations`). None if no C can be
    generated: a sample exceeds its period, or no commit could be accepted.
    """
    try:
        counted = cost_figures(derived := Derived(model), derived.options)
    except (BudgetError, CertificateError):
        return None
    cycles = per_sample(cycles_of(counted.operations))
    held = sum(counted.struct_bytes.get(f"{model.name}_{struct}", 0) for struct in ("t", "learner_t"))
    return Price(cycles.value, held + counted.constant_bytes)


def verdict(study: Study) -> list[str]:
    """The answer, one sentence per line: size of the error, shares of the causes, gain and price of extensions."""
    diagnosis = study.diagnosis
    wrong = (
        f"The simulation is wrong by {_percent(study.percent(diagnosis.base_rms_um))} of the stroke: "
        f"{diagnosis.base_rms_um:.3g} um rms in free run, held out; the noise is {diagnosis.noise.rms_um:.2g} um."
    )
    doubted = doubts(study)
    if unrelated(study.record.segments) is not None:
        return [*doubted, wrong, *_left(diagnosis.unknown)]
    if not _follows(study):
        return [wrong, *doubted, *_left(diagnosis.unknown)]
    wrong = "\n".join([wrong, *doubted])
    if not diagnosis.causes:
        wrong = f"{wrong}\n{diagnosis.remaining.line()}"
        if diagnosis.unknown:
            return [wrong, f"Something stands behind it that none of the known causes explains: {diagnosis.unknown}."]
        if diagnosis.base_rms_um > FAR_ABOVE_NOISE * diagnosis.noise.rms_um and diagnosis.refused:
            reasons = "; ".join(f"{refused.name}: {refused.why}" for refused in diagnosis.refused)
            times = diagnosis.base_rms_um / max(diagnosis.noise.rms_um, 1e-300)
            return [wrong, f"No cause is certain, and the error is {times:.3g} times the noise. Not named: {reasons}."]
        return [wrong, "No cause stands out: it is what the paper's model leaves of plain hysteresis, and noise."]
    left_out = [f"{cause.why_not_extended}." for cause in diagnosis.causes if not cause.extended]
    if not study.extended:
        return [
            wrong,
            "The model written is the paper's: no extension lowers the error on rows left out of the fit for certain.",
            diagnosis.remaining.line(),
            *left_out,
            *_left(diagnosis.unknown),
        ]
    shares = [(cause.name, cause.share) for cause in study.extended if cause.share >= SMALLEST_SHARE]
    parts = [f"{name} is {100.0 * share:.0f} %" for name, share in sorted(shares, key=lambda item: -item[1])]
    small = [cause.name for cause in study.extended if cause.share < SMALLEST_SHARE]
    if small:
        parts.append(f"{_listed(small)} less than 1 %")
    lines = [wrong, f"Of that error (of its power above the noise) {_listed(parts)}."]
    with_all = {1: "With it", 2: "With both"}.get(len(study.extended), "With all of them")
    own_um = diagnosis.remaining.rms_um
    gained = (
        f"{with_all} in the model: {_percent(study.percent(own_um))}, {own_um:.3g} um, "
        f"{diagnosis.base_own_um / max(own_um, 1e-300):.3g} times less"
    )
    if diagnosis.extended_rms_um > COLD_AS_OWN * own_um:
        gained += f" ({diagnosis.extended_rms_um:.3g} um cold: nothing of the scored rows known)"
    total = total_price(study)
    price = f", for about {total.cycles} more cycles a sample and {total.bytes} more bytes" if total else ""
    lines.append(f"{gained}{price}.")
    return [*lines, diagnosis.remaining.line(), *left_out, *_left(diagnosis.unknown)]


def doubts(study: Study) -> list[str]:
    """Sentences about the record that change the answer: they stand beside it."""
    share = unrelated(study.record.segments)
    if share is not None:
        return [
            f"The displacement does not follow the voltage: a linear response explains {100.0 * share:.0f} % of it. "
            "Check that the sensor is connected and the columns are right; no model of it is one of the stage."
        ]
    doubted = _apart(study)
    if not _follows(study):
        linear = coherent_share(max(study.record.segments, key=lambda segment: segment.samples))
        constant = "A constant is as good as every model here of the displacement"
        explained = f": a linear response to the voltage explains {linear:.0%} of it."
        return [*doubted, constant + (" as it is logged." if doubted else explained)]
    if study.lines_prevail:
        doubted.append(
            "The displacement does not follow the voltage: lines that do not depend on it are "
            f"{study.of_lines:.0%} of its power. Check that the sensor is that of the driven axis."
        )
    if fed_back(study.record.segments) is not None:
        doubted.append(
            "The voltage reacts to the displacement: the record was taken under feedback. Creep and drift stand in the "
            "voltage then, and are told apart badly; record in open loop."
        )
    return doubted


def warnings(study: Study) -> list[str]:
    """All that may change the verdict: doubts about the record, what no cause explains, missing certificates."""
    missing = study.diagnosis.missing_certificates
    return [
        *doubts(study),
        *_left(study.diagnosis.unknown),
        *(f"{line}." for line in study.record.warnings),
        *([f"Not certified in the extended model: {', '.join(missing)}."] if missing else []),
    ]


def headline(study: Study) -> str:
    """The main cause and its share in a few words."""
    named = sorted(study.diagnosis.causes, key=lambda cause: -cause.share)
    if not study.follows_voltage:
        return "The displacement does not follow the voltage"
    if study.extended and named[0].share >= SMALLEST_SHARE:
        return f"{named[0].name} is {100.0 * named[0].share:.0f} % of the error"
    if named:
        return f"{_listed([cause.name for cause in named])}: named, and no large part of the error"
    return "No known cause explains the error" if study.diagnosis.unknown else "No cause stands out"


def in_one_sentence(study: Study) -> str:
    """The verdict: the error of the paper's model, and of the model with every cause."""
    diagnosis = study.diagnosis
    own, base_um = diagnosis.remaining, diagnosis.base_rms_um
    said = f"The paper's model is wrong by {_percent(study.percent(base_um))} of the stroke, {base_um:.3g} um"
    if study.extended:
        causes = "this cause" if len(study.extended) == 1 else "these causes"
        said += (
            f"; the model with {causes} by {_percent(study.percent(own.rms_um))}, {own.rms_um:.3g} um: "
            f"{diagnosis.base_own_um / max(own.rms_um, 1e-300):.3g} times less"
        )
    return f"{said}, {own.in_noise:.3g} times the noise."


def _apart(study: Study) -> list[str]:
    """The sentence about logs of voltage and displacement that may not be aligned, if they may not."""
    lag = misaligned(study.record.segments)
    if lag is None:
        return []
    return [
        f"The displacement runs {abs(lag.samples)} samples ({abs(lag.samples) * study.record.Ts_s:.3g} s) {lag.way} "
        "the voltage: unless the stage is so slow, the logs are not aligned, and what follows describes their shift."
    ]


def _follows(study: Study) -> bool:
    """Whether the extended model is better than a constant on the held-out rows."""
    y_um = study.record.y_um
    return study.diagnosis.remaining.rms_um < AS_A_CONSTANT * float(np.std(y_um[study.diagnosis.held_rows]))


def _left(unknown: str | None) -> list[str]:
    """The sentence about the structure that no cause explains, if there is any."""
    return [f"None of the known causes explains the following: {unknown}."] if unknown else []


def total_price(study: Study) -> Price | None:
    """Sum of the prices of all extensions; None if one of them is unknown."""
    prices = [cause.price for cause in study.extended]
    known = [price for price in prices if price is not None]
    if not known or len(known) < len(prices):
        return None
    return Price(sum(price.cycles for price in known), sum(price.bytes for price in known))


def parameter_text(study: Study, name: str) -> str:
    """The parameters of a named cause with their standard errors, where these are known."""
    cause = next(cause for cause in study.diagnosis.causes if cause.name == name)
    return ", ".join(_with_unit(key, estimate) for key, estimate in cause.parameters.items())


def where_rows(study: Study) -> list[list[str]]:
    """One row per error profile: its quantity, smallest and largest rms of the base, the same of the extended model."""
    rows = []
    for before, after in zip(study.before.profiles, study.after.profiles, strict=True):
        rows.append([before.quantity, range_in_words(before), *([range_in_words(after)] if study.improved else [])])
    return rows


def _with_unit(key: str, estimate: Estimate) -> str:
    """A parameter as text: name, value, standard error and unit; a name that is only a unit does not change."""
    end = next((end for end in UNITS if key == end or key.endswith(f"_{end}")), key)
    name, unit = (key, "") if key == end else (key.removesuffix(f"_{end}"), f" {UNITS[end]}")
    return f"{name.replace('_', ' ')} {_with_error(estimate)}{unit}"


def _with_error(estimate: Estimate) -> str:
    """Value and standard error, rounded to the second digit of the error; four digits of a value without one."""
    value, error = estimate.value, estimate.standard_error
    if not (math.isfinite(error) and error > 0.0):
        return decimal(value, 4)
    places = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{places}f} ± {error:.{places}f}" if places <= MOST_PLACES else f"{value:.4g} ± {error:.2g}"


def _percent(value: float) -> str:
    return f"{value:.2g} %"


def _listed(parts: Sequence[str]) -> str:
    """The parts as "a, b and c"."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
