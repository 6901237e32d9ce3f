"""Whether the excitation of a record is enough for rules and parameters, and covers the validation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.data import SAME_PERIOD, Record
from hysgen.record.series import turning_rows, white_noise

PER_PARAMETER = 4
"""Least number of steps y(k) to y(k+1) per parameter; typical records have hundreds."""
SEPARATE = 0.03
"""Least rms of y about its regression line on u in a rule's cell, relative to the rms of y there, to separate both."""
OUTSIDE = 0.005
"""Part of the identified range by which validation may exceed it without a warning: noise at the turning points."""

FITTED_RECORD = "is the record that was fitted; its scores say nothing about other records"

Series = NDArray[np.float64]


def check_for_fit(record: Record, rules: int, parameters: int) -> tuple[str, ...]:
    """Refuse a record with too few samples for the model; return warnings, one line each, on poor excitation.

    rules: L of Eq. (1); the cell of a rule is the part of the range of y that is nearest to its centre, Eq. (6).
    parameters: number of all fitted coefficients, 3 L and those of the extensions.

    Warnings: rules with too few samples; coefficients that the record does not determine; equal swings of the voltage.
    Raises RecordError if there are fewer than 4 steps for each parameter.
    """
    if rules < 1 or parameters < 1:
        raise RecordError(f"{record.source}: {rules} rules with {parameters} parameters; choose at least one of each")
    wanted = max(parameters, 3 * rules)
    steps = record.samples - len(record.segments)
    if steps < PER_PARAMETER * wanted:
        raise RecordError(
            f"{record.source}: {record.samples} samples are too few for {rules} rules with {wanted} parameters "
            f"(at least {PER_PARAMETER * wanted + len(record.segments)}); record longer, or choose fewer rules"
        )
    return (*_cells(record, rules), *_alike(record))


@dataclass(frozen=True)
class Conditions:
    """The conditions under which a model was identified.

    source, digest: of the record; "" if unknown. fastest_V_per_s: 99.9 % quantile of the speed of the voltage, None if
    unknown. aux_names: further channels.
    """

    source: str
    Ts_s: float
    u_range_V: tuple[float, float]
    y_range_um: tuple[float, float]
    fastest_V_per_s: float | None
    digest: str
    aux_names: tuple[str, ...] = ()

    @classmethod
    def of(cls, record: Record) -> Conditions:
        """The conditions of a record."""
        return cls(
            record.source,
            record.Ts_s,
            record.u_range_V,
            record.y_range_um,
            fastest_V_per_s(record),
            record.digest,
            record.aux_names,
        )


def check_validation(identification: Record | Conditions, validation: Record) -> tuple[str, ...]:
    """Warnings, one line each, where the validation record exceeds the conditions of the identification record.

    Voltages and displacements outside its ranges, faster voltage, missing channels, and the identical record.
    Raises RecordError if the sampling periods differ.
    """
    source = validation.source
    if isinstance(identification, Record):
        identification = Conditions.of(identification)
    if abs(validation.Ts_s - identification.Ts_s) > SAME_PERIOD * identification.Ts_s:
        raise RecordError(
            f"{source}: sampled every {validation.Ts_s:g} s, but {identification.source} every "
            f"{identification.Ts_s:g} s; resample one of them"
        )
    warnings = []
    if validation.digest == identification.digest:
        warnings.append(f"{source}: {FITTED_RECORD}")
    clamped, unseen = "the model is clamped there", "no row has identified the model there"
    for what, unit, (low, high), channels, then in (
        ("voltage", "V", identification.u_range_V, [one.u_V for one in validation.segments], clamped),
        ("displacement", "um", identification.y_range_um, [one.y_um for one in validation.segments], unseen),
    ):
        values = np.concatenate(channels)
        margin = OUTSIDE * (high - low)
        outside = int(np.count_nonzero((values < low - margin) | (values > high + margin)))
        if outside:
            warnings.append(
                f"{source}: {what} {values.min():.6g}..{values.max():.6g} {unit} leaves the identified "
                f"{low:.6g}..{high:.6g} {unit} in {outside} of {values.size} samples; {then}: "
                "identify over the whole range"
            )
    identified, needed = identification.fastest_V_per_s, fastest_V_per_s(validation)
    if identified is not None and needed > 1.2 * identified:
        warnings.append(
            f"{source}: voltage moves by up to {needed:.4g} V/s, in identification by up to {identified:.4g} V/s; "
            "identify with signals as fast"
        )
    for name in identification.aux_names:
        if name not in validation.aux_names:
            warnings.append(
                f"{source}: lacks the channel {name} of {identification.source}; a model using it cannot run"
            )
    return tuple(warnings)


def _cells(record: Record, rules: int) -> Iterator[str]:
    """Warnings on rules with few samples, and on rules in whose cell y is a function of u.

    A cell with samples determines the constant of its rule; the slope in y if y varies there; the slope in u if y is no
    function of u there:  rms(y - line in u) > max(0.03 s, min(3 noise, 0.7 s)),  s = rms(y - mean).
    The limit of 3 noise keeps noise from counting; 0.7 s is for fast signals, which the noise estimate takes for noise.
    """
    u = np.concatenate([one.u_V[:-1] for one in record.segments])
    y = np.concatenate([one.y_um[:-1] for one in record.segments])
    low, high = record.y_range_um
    noise = max(white_noise(one.y_um) for one in record.segments)
    step = (high - low) / max(rules - 1, 1) or 1.0
    cell = np.rint((y - low) / step).astype(np.intp) if rules > 1 else np.zeros(y.size, dtype=np.intp)
    count = np.bincount(cell, minlength=rules)

    def mean(values: Series) -> Series:
        return np.asarray(np.bincount(cell, values, minlength=rules) / np.maximum(count, 1))

    u = u - mean(u)[cell]
    y = y - mean(y)[cell]
    uu, yy, uy = mean(u * u), mean(y * y), mean(u * y)
    unexplained = yy - np.divide(uy * uy, uu, out=np.zeros(rules), where=uu > 0.0)
    poor = count < 3 * PER_PARAMETER
    moving = ~poor & (yy > 0.0)
    separate = moving & (uu > 0.0) & (unexplained > np.maximum(SEPARATE**2 * yy, np.minimum(9.0 * noise**2, 0.5 * yy)))
    if poor.any():
        shown = _listed(
            [f"{rule + 1} (y near {low + rule * step:.4g} um: {count[rule]})" for rule in np.flatnonzero(poor)]
        )
        yield (
            f"{record.source}: {np.count_nonzero(poor)} of {rules} rules see fewer than {3 * PER_PARAMETER} samples: "
            f"rule {shown}; choose fewer rules, or dwell there"
        )
    determined = int(np.count_nonzero(~poor) + np.count_nonzero(moving) + np.count_nonzero(separate))
    if determined < 3 * rules:
        together = _listed([str(rule + 1) for rule in np.flatnonzero(moving & ~separate)])
        because = f": voltage and displacement move as one in rules {together}" if together else ""
        yield (
            f"{record.source}: excitation tells about {determined} of {3 * rules} rule coefficients apart{because}; "
            "add nested amplitudes and other frequencies, or choose fewer rules"
        )


def _listed(words: list[str]) -> str:
    return ", ".join(words[:5]) + (f" and {len(words) - 5} more" if len(words) > 5 else "")


def _alike(record: Record) -> Iterator[str]:
    """A warning if the voltage has fewer than two full swings, or if all swings have one size and one duration."""
    low, high = record.u_range_V
    sizes: list[float] = []
    durations: list[float] = []
    turns = 0
    for one in record.segments:
        rows = turning_rows(one.u_V, 0.02 * (high - low))
        turns += rows.size
        # Swings before the first and after the last turning point are incomplete.
        sizes.extend(np.abs(np.diff(one.u_V[rows])).tolist())
        durations.extend((np.diff(rows) * record.Ts_s).tolist())
    if len(sizes) < 2:
        yield (
            f"{record.source}: the voltage turns {turns} times; memory cannot be told from lag: "
            "drive several cycles of different size"
        )
    elif max(sizes) < 1.05 * min(sizes) and max(durations) < 1.2 * min(durations):
        yield (
            f"{record.source}: all {len(sizes)} swings of the voltage are alike ({np.median(sizes):.4g} V in "
            f"{np.median(durations):.4g} s); memory, lag and creep cannot be told apart: add other sizes and speeds"
        )


def fastest_V_per_s(record: Record) -> float:
    """99.9 % quantile of the speed of the voltage in V/s; the quantile ignores single jumps."""
    steps = np.concatenate([np.abs(np.diff(one.u_V)) for one in record.segments])
    return float(np.quantile(steps, 0.999)) / record.Ts_s if steps.size else 0.0
