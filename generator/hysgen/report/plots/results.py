"""Pictures of the method `.plot()` of a result."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hysgen.certify.certificates import dynamics
from hysgen.checking.cost import Cost
from hysgen.diagnosis.evaluation import Study
from hysgen.errors import HysgenError
from hysgen.feedback.certificate import LoopDesign
from hysgen.model.model import Model
from hysgen.model.scores import Scores
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.report.plots import style
from hysgen.report.plots.diagnosis import pictures
from hysgen.report.plots.traces import LOOP_POINTS, envelope, horizon, validation
from hysgen.trajectory.plan import Waveform


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure that a notebook displays as PNG."""

    figure: Figure

    def __post_init__(self) -> None:
        style.named(self.figure)

    def save(self, path: str | Path) -> Path:
        """Write the figure as SVG if the name ends in .svg, else as PNG. Returns the path."""
        return style.save(self.figure, Path(path))

    def _repr_png_(self) -> bytes:
        return style.png_bytes(self.figure)


@functools.singledispatch
def draw(result: Any, *what: Any) -> Drawing:
    """The picture of a result. Raises HysgenError if results of its type have none."""
    raise HysgenError(f"{type(result).__name__}: there is nothing to plot; print it instead")


@draw.register
def _(result: Record) -> Drawing:
    """Input and displacement against time, and displacement against input."""
    fig, above, below, side = style.axes_beside()
    for segment in result.segments:
        t_s = segment.start_s + result.Ts_s * np.arange(segment.samples, dtype=np.float64)
        above.plot(*envelope(t_s, segment.u_V), color=style.EXTENDED, linewidth=style.THIN)
        below.plot(*envelope(t_s, segment.y_um), color=style.MEASURED, linewidth=style.THIN)
        stride = max(1, -(-segment.samples // LOOP_POINTS))
        side.plot(segment.u_V[::stride], segment.y_um[::stride], color=style.MEASURED, linewidth=style.THIN)
    above.set(ylabel="voltage [V]", title=result.source)
    below.set(xlabel="time [s]", ylabel="displacement [µm]")
    side.set(xlabel="voltage [V]", ylabel="displacement [µm]")
    return Drawing(fig)


@draw.register
def _(result: Model, record: Record | None = None) -> Drawing:
    """With a record: free run and error. Without: area of the loop, as a share of its bounding box, by frequency."""
    if record is not None:
        runs = {"free run": free_run(result, record)[0].y_um}
        title = f"{result.name} on {record.source}"
        return Drawing(validation(record, runs, title, {"free run": style.SIMULATED}))
    system = dynamics(result)
    fig, axis = style.axes("frequency [Hz]", "loop fills its box [%]")
    axis.semilogx([loop.f_Hz for loop in system.loops], [100.0 * loop.filling for loop in system.loops], marker=".")
    axis.set(title=result.name, ylim=(0.0, None))
    return Drawing(fig)


@draw.register
def _(result: Scores) -> Drawing:
    """Error against the horizon, with noise floor and free run."""
    levels = {"noise floor": result.noise.rms_um, "free run": result.free_run.e_rms_um}
    name = f"{result.model} on {result.source}"
    return Drawing(horizon({name: result.horizon}, levels, result.Ts_s, {name: {"color": style.EXTENDED}}).figure)


@draw.register
def _(result: Study, name: str = "ladder") -> Drawing:
    """One picture of the report, by name. Raises HysgenError for a name that is not among them."""
    drawn = {picture.name: picture for picture in pictures(result)}
    if name not in drawn:
        raise HysgenError(f"{name}: there is no such picture; choose one of {', '.join(drawn)}")
    return Drawing(drawn[name].figure)


@draw.register
def _(result: Cost) -> Drawing:
    """Cycles of every function against the sample period."""
    fig = style.figure(5.6, 0.5 + 0.35 * (len(result.functions) + 1))
    axis = fig.subplots()
    shown = [f for f in result.functions if f.name != "init"]
    axis.barh([f.name for f in shown], [f.cycles.value for f in shown], color=style.EXTENDED, height=0.6)
    axis.axvline(result.budget, color=style.SIMULATED, linestyle="--", label=f"sample period, {result.budget}")
    axis.invert_yaxis()
    axis.set(xlabel="C674x cycles, stall-free", title=result.model)
    axis.legend(loc="lower right")
    return Drawing(fig)


@draw.register
def _(result: Waveform) -> Drawing:
    """Voltage with its limits, reference and displacement, and the error that the limits leave."""
    fig, above, below, side = style.axes_beside()
    time_s = result.reference.start_s + result.Ts_s * np.arange(result.y_um.size, dtype=np.float64)
    above.plot(*envelope(result.time_s, result.u_V), color=style.EXTENDED, linewidth=style.THIN)
    for limit_V in (result.limits.low_V, result.limits.high_V):
        above.axhline(limit_V, color=style.NOTE, linestyle="--")
    below.plot(*envelope(time_s, result.reference.values), color=style.MEASURED, label="reference")
    below.plot(*envelope(time_s, result.y_um), color=style.SIMULATED, linestyle="--", label="answer of the model")
    side.plot(*envelope(time_s, result.y_um - result.reference.values), color=style.SIMULATED)
    above.set(ylabel="voltage [V]", title=f"{result.reference.source} with {result.model}")
    below.set(xlabel="time [s]", ylabel="displacement [µm]")
    below.legend(loc="upper left", ncols=2)
    side.set(xlabel="time [s]", ylabel="answer - reference [µm]")
    return Drawing(fig)


@draw.register
def _(result: LoopDesign) -> Drawing:
    """|L| of every draw and phase of the model itself against frequency, and the displacement after a push."""
    fig, above, below, side = style.axes_beside()
    c = result.certificate
    above.fill_between(result.f_Hz, *(20.0 * np.log10(result.size)), color=style.EXTENDED, alpha=0.4, linewidth=0.0)
    below.plot(result.f_Hz, result.phase_deg, color=style.EXTENDED)
    for axis, level in ((above, 0.0), (below, -180.0)):
        axis.axhline(level, color=style.NOTE, linestyle="--")
        axis.axvline(c.bandwidth_Hz, color=style.SIMULATED)
        axis.set(xscale="log", xlim=(0.01 * c.bandwidth_Hz, result.f_Hz[-1]))
    time_ms = 1e3 * result.Ts_s * np.arange(result.steps.shape[1])
    side.plot(time_ms, result.steps.T, color=style.EXTENDED, linewidth=style.THIN, alpha=0.3)
    above.set(ylabel="|L| [dB], all draws", ylim=(-60.0, 40.0), title=f"{result.model}: {c.bandwidth_Hz:.4g} Hz")
    below.set(xlabel="frequency [Hz]", ylabel="phase [degrees]", ylim=(-720.0, 0.0))
    side.set(xlabel="time [ms]", ylabel="displacement after a push of 1")
    return Drawing(fig)
