"""Whether the excitation of a record covers that of another, on which a model is validated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.data import SAME_PERIOD, Record

OUTSIDE = 0.005
"""Part of the identified range by which validation may exceed it without a warning: noise at the turning points."""

FITTED_RECORD = "is the record that was fitted; its scores say nothing about other records"


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


def fastest_V_per_s(record: Record) -> float:
    """99.9 % quantile of the speed of the voltage in V/s; the quantile ignores single jumps."""
    steps = np.concatenate([np.abs(np.diff(one.u_V)) for one in record.segments])
    return float(np.quantile(steps, 0.999)) / record.Ts_s if steps.size else 0.0
