"""Pictures: figures are made from data and returned; only `save` writes.

Here the common style of all: colours for colour-blind readers, axes, file formats, title and alt text.
"""

import io
import math
import pickle
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from hysgen.display import WRITTEN_IN
from hysgen.machine.files import write_whole
from hysgen.report import BLUE, GREEN, VERMILION

MEASURED, NOTE = "#000000", "#999999"
SIMULATED, EXTENDED, BASELINE = VERMILION, BLUE, GREEN
THIN = 0.8
"""Width of the line of a signal, whose swings lie close together, in points; other lines: see _SETTINGS."""

BEHIND = "#777777"
"""Colour of the measured displacement where a simulation is drawn over it."""

BASE_MODEL, EXTENDED_MODEL = "paper's model", "extended model"
LINES: dict[str, dict[str, Any]] = {
    BASE_MODEL: {"color": SIMULATED, "linestyle": (0, (4, 1.5))},
    EXTENDED_MODEL: {"color": EXTENDED, "linestyle": "solid"},
}
"""Line of each model in the pictures of a diagnosis."""

LETTERS_BESIDE = 56
"""Letters that stand side by side in a legend over half the page; each line of a legend takes the place of six."""

HALF_IN = (4.7, 3.1)
"""Size of a picture that stands beside another one."""

WIDE_IN = (9.6, 3.4)
"""Size of a picture over the whole width of the page; letters appear as large as in the others."""

HALF_A_DECADE = 0.6
"""Decades of a logarithmic axis below which 1, 2 and 5 may leave it with one label."""

_SETTINGS: Any = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.hashsalt": "hysgen",
    "path.simplify_threshold": 0.5,
}


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure for reports. name: stem of its file; title: the question it answers; alt: its content and numbers.

    wide: takes the whole width of the page.
    """

    name: str
    title: str
    alt: str
    figure: Figure
    wide: bool = False


def figure(width_in: float = 7.2, height_in: float = 4.2) -> Figure:
    """An empty figure in the project's style; constrained layout keeps labels apart."""
    matplotlib.rcParams.update(_SETTINGS)
    return Figure(figsize=(width_in, height_in), layout="constrained")


def axes(xlabel: str, ylabel: str) -> tuple[Figure, Axes]:
    """A figure that stands beside another one, and its only axes."""
    fig = figure(*HALF_IN)
    axis = fig.subplots()
    axis.set(xlabel=xlabel, ylabel=ylabel)
    return fig, axis


def axes_beside() -> tuple[Figure, Axes, Axes, Axes]:
    """A wide figure: two axes above each other, and one to the right of both."""
    fig = figure(*WIDE_IN)
    grid = fig.add_gridspec(2, 2, width_ratios=(1.7, 1.0))
    return fig, fig.add_subplot(grid[0, 0]), fig.add_subplot(grid[1, 0]), fig.add_subplot(grid[:, 1])


def note(axis: Axes, text: str, place: tuple[float, float], coords: tuple[str, str], side: Any, aside: int = 0) -> None:
    """Small letters above a place, at its `side`, and outside the frame, too."""
    axis.annotate(
        text,
        place,
        xycoords=coords,
        xytext=(aside, 2),
        textcoords="offset points",
        ha=side,
        va="bottom",
        fontsize="small",
        annotation_clip=False,
    )


def level(axis: Axes, level_um: float, name: str) -> None:
    """A dotted line over the width of the axes, with its name at the right end."""
    axis.axhline(level_um, color=BEHIND, linestyle=":")
    note(axis, name, (1.0, level_um), ("axes fraction", "data"), "right")


def legend_above(axis: Axes) -> None:
    """The legend above the axes, where it covers no curve: in one line if it fits, or in two columns."""
    names = axis.get_legend_handles_labels()[1]
    columns = len(names) if sum(map(len, names)) + 6 * len(names) <= LETTERS_BESIDE else 2
    axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, columnspacing=1.2)


def decimal_ticks(axis: Axes) -> None:
    """Decimal tick labels on logarithmic axes of x and y."""
    for line in (axis.yaxis, axis.xaxis):
        decimal_ticks_of(line)


class FewLabels(LogLocator):
    """Places of the labels of a logarithmic axis: 1, 2 and 5 of each decade, or decades alone where `most` would be
    exceeded; within half a decade, evenly spaced ones."""

    def __init__(self, most: int) -> None:
        super().__init__(numticks=most)
        self.most = most

    def tick_values(self, vmin: float, vmax: float) -> Any:
        decades = math.log10(max(vmax, 1e-300) / max(vmin, 1e-300))
        if decades < HALF_A_DECADE:
            return MaxNLocator(min(self.most, 5)).tick_values(vmin, vmax)
        self.set_params(subs=(1.0, 2.0, 5.0) if 3.0 * decades <= self.most else (1.0,))
        return super().tick_values(vmin, vmax)


def decimal_ticks_of(line: Axis, most: int = 9) -> None:
    """Decimal tick labels on a logarithmic axis, at most `most`, so that they do not lie on each other."""
    line.set_major_locator(FewLabels(most))
    line.set_minor_formatter(NullFormatter())
    line.set_major_formatter(FuncFormatter(plain_number))


def png_bytes(fig: Figure, dpi: int = 150) -> bytes:
    """The figure as PNG without version and date: the same figure gives the same bytes."""
    stream = io.BytesIO()
    _undrawn(fig).savefig(stream, format="png", dpi=dpi, metadata={"Software": "hysgen"})
    return stream.getvalue()


def svg_bytes(fig: Figure) -> bytes:
    """The figure as SVG, text as outlines, element names salted, no date: the same figure gives the same bytes."""
    matplotlib.rcParams.update(_SETTINGS)
    stream = io.BytesIO()
    _undrawn(fig).savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def _undrawn(fig: Figure) -> Figure:
    """A copy to draw: drawing moves the axes of a figure, and the next drawing begins where they are."""
    copy: Figure = pickle.loads(pickle.dumps(named(fig)))
    return copy


def named(fig: Figure) -> Figure:
    """The figure, with names and units of the quantities in which texts are written."""
    for text in fig.findobj(Text):
        text.set_text(WRITTEN_IN.get().text(text.get_text()))
    return fig


def data_uri(fig: Figure) -> str:
    """The figure as SVG inside a `data:` address: a page that shows it needs no other file.

    Lines without blanks and quotes that HTML does not escape: two thirds of the size of base64.
    """
    text = svg_bytes(fig).decode()
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'(?<= d=")[^"]*', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), text)
    text = re.sub(r"\s+", " ", text).replace("> <", "><")
    return "data:image/svg+xml," + text.replace('"', "'").replace("%", "%25").replace("#", "%23")


def plain_number(value: float, _: int | None = None) -> str:
    """Label of a tick without an exponent where it is short. No lambda: figures are pickled."""
    return f"{value:.5f}".rstrip("0") if 0.99e-5 < value < 1e-4 else f"{value:g}"


def save(fig: Figure, path: Path) -> Path:
    """Write the figure, whole or not at all: as SVG if the name ends in .svg, else as PNG. Returns the path."""
    write_whole(path, svg_bytes(fig) if path.suffix == ".svg" else png_bytes(fig))
    return path
