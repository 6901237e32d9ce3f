"""Measured and simulated displacement: in time, as error, as hysteresis loops (the paper's Figs 6, 7, 9 to 11, 13)."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hysgen.model.simulate import HorizonCurve
from hysgen.record import Record
from hysgen.report.plots import style

Floats = NDArray[np.float64]
MOST_POINTS = 20_000
"""Most points drawn per curve: more are not visible and make the file slow to open."""


def validation(record: Record, simulated_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]) -> Figure:
    """Displacement against time, measured and simulated, and below it the errors, simulated - measured.

    Each error has an axis of its own: on one axis, the smaller is flat. Shows the first segment of the record.
    simulated_um: (n,) by name in the legend; colours: by the same names.
    """
    measured_um, t_s = record.segments[0].y_um, times_s(record)
    count = len(simulated_um)
    fig = style.figure(7.2, 3.2 + 1.4 * count)
    above, *others = fig.subplots(1 + count, 1, sharex=True, height_ratios=[2.0] + [1.0] * count)
    keep = thinned(t_s.size)
    above.plot(t_s[keep], measured_um[keep], color=style.MEASURED, label="measured")
    for below, (name, y_um) in zip(others, simulated_um.items(), strict=True):
        above.plot(t_s[keep], y_um[keep], color=colours[name], linestyle="--")
        error_um = y_um - measured_um
        rms_um = float(np.sqrt(np.mean(error_um**2)))
        below.plot(t_s[keep], error_um[keep], color=colours[name], label=f"{name}: {rms_um:.2g} µm rms")
    above.set(ylabel="displacement [µm]", title=title)
    others[-1].set(xlabel="time [s]")
    # In the middle of all axes of errors: of the middle one, or between the two.
    others[(count - 1) // 2].set_ylabel("simulated - measured [µm]", y=0.5 if count % 2 else 0.0)
    fig.legend(loc="outside lower center", ncols=2)
    return fig


def loops(record: Record, simulated_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]) -> Figure:
    """Displacement against voltage over the first segment: one panel per simulation, each with the measured loops."""
    u_V, measured_um = record.segments[0].u_V, record.segments[0].y_um
    fig = style.figure(3.4 * len(simulated_um) + 0.6, 3.4)
    panels = np.atleast_1d(fig.subplots(1, len(simulated_um), sharex=True, sharey=True))
    keep = thinned(u_V.size)
    for panel, (name, y_um) in zip(panels, simulated_um.items(), strict=True):
        panel.plot(u_V[keep], measured_um[keep], color=style.MEASURED, label="measured")
        panel.plot(u_V[keep], y_um[keep], color=colours[name], label=name)
        panel.set(xlabel="voltage [V]", title=name if len(simulated_um) > 1 else "")
        panel.legend(loc="upper left")
    panels[0].set_ylabel("displacement [µm]")
    fig.suptitle(title)
    return fig


def tracking(
    t_s: Floats, reference_um: Floats, reached_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]
) -> Figure:
    """Reference and reached displacement, tracking error in nm, reached against reference (ideally a straight line).

    Error: reached - reference.
    """
    fig, above, below, side = style.axes_beside()
    keep = thinned(t_s.size)
    above.plot(t_s[keep], reference_um[keep], color=style.MEASURED, label="reference")
    for name, y_um in reached_um.items():
        above.plot(t_s[keep], y_um[keep], color=colours[name], label=name, linestyle="--")
        below.plot(t_s[keep], 1e3 * (y_um - reference_um)[keep], color=colours[name])
        side.plot(reference_um[keep], y_um[keep], color=colours[name], label=name)
    above.set(ylabel="displacement [µm]", title=title)
    below.set(xlabel="time [s]", ylabel="reached - reference [nm]")
    side.set(xlabel="reference [µm]", ylabel="reached [µm]", title="compensated loop")
    side.legend(loc="upper left")
    return fig


def horizon(
    curves: Mapping[str, HorizonCurve],
    levels_um: Mapping[str, float],
    Ts_s: float,
    title: str,
    lines: Mapping[str, Mapping[str, Any]],
) -> Figure:
    """Error rms against the horizon, both axes logarithmic, with a horizontal line for each of `levels_um`."""
    fig, axis = style.axes("horizon [ms]", "error rms [µm]")
    for name, curve in curves.items():
        steps = np.array(curve.steps, dtype=np.float64)
        axis.loglog(steps * Ts_s * 1e3, curve.rms_um, marker=".", label=name, **lines[name])
    for name, level_um in levels_um.items():
        style.level(axis, level_um, name)
    style.decimal_ticks(axis)
    if title:
        axis.set_title(title)
        axis.legend(loc="upper left")
    else:
        style.legend_above(axis)
    return fig


def times_s(record: Record) -> Floats:
    """Time stamps in s of the first segment, (n,)."""
    segment = record.segments[0]
    return segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64)


def envelope(t_s: Floats, values: Floats, pieces: int = 1000) -> tuple[Floats, Floats]:
    """Minimum and maximum of each of `pieces` equal intervals, in time order: a reduced curve that keeps all peaks.

    t_s, values: (n,). Returns them unchanged if n <= 2 * pieces.
    """
    if values.size <= 2 * pieces:
        return t_s, values
    bounds = np.linspace(0, values.size, pieces + 1).astype(np.intp)
    kept = []
    for low, high in itertools.pairwise(bounds):
        part = values[low:high]
        kept += sorted({low + int(part.argmin()), low + int(part.argmax())})
    return t_s[kept], values[kept]


def thinned(samples: int) -> slice:
    """A slice with a constant stride that leaves at most MOST_POINTS of the samples."""
    return slice(None, None, max(1, -(-samples // MOST_POINTS)))
