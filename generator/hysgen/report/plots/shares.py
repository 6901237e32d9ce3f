"""Picture of the share of the error's power by cause, over the time of the record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.evaluation import Study
from hysgen.report.plots import style
from hysgen.report.plots.measured import time_label
from hysgen.report.plots.style import Picture

Floats = NDArray[np.float64]

WINDOWS = 60
"""Windows over the record, each with the mean square of the error."""

COLOURS = (style.EXTENDED, "#e69f00", style.BASELINE, "#cc79a7", "#56b4e9", "#f0e442", style.SIMULATED)
"""Of the extensions, in ladder order: Okabe and Ito (2008), as in `style`."""


def error_shares(errors_um: list[Floats], noise_um: float, edges: NDArray[np.intp]) -> Floats:
    """(m + 2, w) share of the noise, of what no extension explains, and of each of m extensions, in each window.

        share of extension i = (p_(i-1) - p_i) / p_0,    p_i: mean square of the error of rung i, at most p_(i-1)

    errors_um: (n,) of rungs 0 to m. edges: (w + 1,) rows at which the windows begin. The shares of a window sum to 1.
    """
    powers = np.stack([np.add.reduceat(error * error, edges[:-1]) / np.diff(edges) for error in errors_um])
    falling = np.minimum.accumulate(powers, axis=0)
    noise = np.minimum(noise_um**2, falling[-1])
    parts = np.vstack([noise, falling[-1] - noise, falling[:-1] - falling[1:]])
    return np.asarray(parts / np.maximum(falling[0], 1e-300))


def shares_picture(study: Study) -> Picture:
    """The shares of the paper's model's error over the time of the record: noise, unexplained, each extension."""
    diagnosis, record = study.diagnosis, study.record
    edges = np.linspace(0, record.samples, min(WINDOWS, record.samples) + 1).astype(np.intp)
    shares = error_shares([error for _, error in diagnosis.errors_um], diagnosis.noise.rms_um, edges)
    # The name of a rung lists its causes; the last one is its own.
    names = ["noise", "not explained", *(name.rpartition(" + ")[2] for name, _ in diagnosis.errors_um[1:])]
    colours = ["#cccccc", "#666666", *COLOURS, *COLOURS]
    fig = style.figure(*style.WIDE_IN)
    axis = fig.subplots()
    axis.set(xlabel=time_label(study), ylabel="share of the error's power [%]")
    time_s = record.Ts_s * edges
    # Each window is a step, so that no slope is drawn that was not measured.
    steps = np.repeat(100.0 * shares, 2, axis=1)
    axis.stackplot(np.repeat(time_s, 2)[1:-1], steps, labels=names, colors=colours)
    axis.axvline(record.Ts_s * study.cut, color=style.MEASURED, linestyle=":")
    style.note(axis, "held out", (record.Ts_s * study.cut, 1.0), ("data", "axes fraction"), "left")
    axis.set_xlim(0.0, float(time_s[-1]))
    axis.set_ylim(0.0, 100.0)
    fig.legend(loc="outside right center", reverse=True)
    held = shares[:, edges[:-1] >= study.cut]
    means = held.mean(axis=1) if held.size else shares.mean(axis=1)
    words = ", ".join(f"{name} {100.0 * mean:.0f} %" for name, mean in zip(names, means, strict=True))
    alt = f"Share of the paper's model's error by cause, mean over the windows of the held-out part: {words}."
    return Picture("shares", "Which cause makes the error, and when", alt, fig, wide=True)
