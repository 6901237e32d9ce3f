"""A diagnosis in words: how wrong the simulation is, what of it is what, and what mending it costs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hysgen.diagnosis.answer import NamedCause, Price
from hysgen.diagnosis.causes import Estimate
from hysgen.diagnosis.error_map import spread
from hysgen.diagnosis.study import Study

UNITS = ("um", "V", "s", "Hz", "samples")
"""Units that names of parameters end with."""

SMALLEST_SHARE = 0.005
"""Causes below this share of the error's power are counted together as `the rest`."""


def verdict(study: Study) -> list[str]:
    """The answer in a few sentences, each one line."""
    found = study.diagnosis
    wrong = (
        f"The simulation is wrong by {_percent(study.percent(found.base_rms_um))} of the stroke: "
        f"{found.base_rms_um:.3g} um rms in free run, held out; the noise is {found.noise.rms_um:.2g} um."
    )
    if not found.causes:
        if found.unknown:
            return [wrong, f"Something stands behind it that none of the known causes explains: {found.unknown}."]
        return [wrong, "No cause stands out: it is what the paper's model leaves of plain hysteresis, and noise."]
    left_out = [cause.name for cause in found.causes if not cause.extended]
    also = f"{', '.join(left_out)}: seen in the record, but not extended, for that does not pay with certificates kept."
    if not study.extended:
        return [wrong, f"Named: {also}", *_left(found.unknown)]
    shares = [(cause.name, cause.share) for cause in study.extended if cause.share >= SMALLEST_SHARE]
    parts = [f"{name} is {100.0 * share:.0f} %" for name, share in sorted(shares, key=lambda item: -item[1])]
    small = [cause.name for cause in study.extended if abs(cause.share) < SMALLEST_SHARE]
    worse = [(cause.name, -cause.share) for cause in study.extended if cause.share <= -SMALLEST_SHARE]
    if small:
        parts.append(f"{_listed(small)} less than 1 %")
    parts += [f"{name} adds {100.0 * share:.0f} % here" for name, share in worse]
    lines = [wrong, f"Of that error (of its power above the noise) {_listed(parts)}."]
    with_all = {1: "With it", 2: "With both"}.get(len(study.extended), "With all of them")
    gained = (
        f"{with_all} in the model: {_percent(study.percent(found.extended_rms_um))}, {found.extended_rms_um:.3g} um, "
        f"{found.base_rms_um / max(found.extended_rms_um, 1e-300):.3g} times less"
    )
    total = price_of_all(study)
    price = f", for about {total.cycles} more cycles a sample and {total.bytes} more bytes" if total else ""
    lines.append(f"{gained}{price}.")
    return [*lines, *([f"Also named: {also}"] if left_out else []), *_left(found.unknown)]


def _left(unknown: str | None) -> list[str]:
    """The sentence about what nothing explains."""
    return [f"Structure is left that none of the known causes explains: {unknown}."] if unknown else []


def price_of_all(study: Study) -> Price | None:
    """What all extensions cost together; None where a price is not known."""
    prices = [cause.price for cause in study.extended]
    known = [price for price in prices if price is not None]
    if not known or len(known) < len(prices):
        return None
    return Price(sum(price.cycles for price in known), sum(price.bytes for price in known))


def ladder_header() -> list[str]:
    """Column heads of `ladder_rows`."""
    return ["step", "free run um", "of stroke", "gain um, 95 %", "of the error", "cycles", "bytes", "confidence"]


def ladder_rows(study: Study) -> list[list[str]]:
    """One row per rung of the ladder, and the noise floor below."""
    found = study.diagnosis
    rows = [["paper's model", f"{found.base_rms_um:.4g}", _percent(study.percent(found.base_rms_um)), *[""] * 5]]
    for cause in study.extended:
        price = cause.price
        rows.append(
            [
                f"+ {cause.name}",
                f"{cause.step.after_um:.4g}",
                _percent(study.percent(cause.step.after_um)),
                f"{cause.step.low_um:.3g} .. {cause.step.high_um:.3g}",
                f"{100.0 * cause.share:.1f} %",
                f"+{price.cycles}" if price and price.cycles else "",
                f"+{price.bytes}" if price and price.bytes else "",
                confidence_text(cause),
            ]
        )
    noise = found.noise.rms_um
    rows.append(["noise floor", f"{noise:.4g}", _percent(study.percent(noise)), *[""] * 5])
    return rows


CONFIDENCE = (
    "confidence: share of bootstrap draws on blocks left out in which the extension lowers the error by more than 2 %"
)
"""What the column of that name holds."""


def confidence_text(cause: NamedCause) -> str:
    """How sure the gain of a cause is; nothing where it is not measured."""
    return "" if cause.confidence is None else f"{cause.confidence:.3f}"


def parameter_text(study: Study, name: str) -> str:
    """The parameters of a named cause with their standard errors, where these are known."""
    cause = next(cause for cause in study.diagnosis.causes if cause.name == name)
    return ", ".join(_with_unit(key, estimate) for key, estimate in cause.parameters.items())


def where_rows(study: Study) -> list[list[str]]:
    """By what the error changes: lowest and highest rms of each profile, before and after."""
    rows = []
    for before, after in zip(study.before.profiles, study.after.profiles, strict=True):
        rows.append([before.quantity, spread(before), *([spread(after)] if study.improved else [])])
    return rows


def _with_unit(key: str, estimate: Estimate) -> str:
    """A parameter in words: its unit stands behind the number instead of at the end of its name."""
    stem, _, unit = key.rpartition("_")
    name, unit = (stem.replace("_", " "), f" {unit}") if unit in UNITS and stem else (key.replace("_", " "), "")
    spread = f" ± {estimate.standard_error:.2g}" if math.isfinite(estimate.standard_error) else ""
    return f"{name} {estimate.value:.4g}{spread}{unit}"


def _percent(value: float) -> str:
    return f"{value:.2g} %"


def _listed(parts: Sequence[str]) -> str:
    """a, b and c."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
