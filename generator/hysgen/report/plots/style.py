"""Common style of all pictures: colours for colour-blind readers, axes, file formats, title and alt text."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from hysgen.machine.files import write_whole

# Okabe and Ito (2008), "Color Universal Design": distinct for all common kinds of colour blindness.
MEASURED = "#000000"
SIMULATED = "#d55e00"
EXTENDED = "#0072b2"
BASELINE = "#009e73"
NOTE = "#999999"

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
    "agg.path.chunksize": 20000,
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


def png_bytes(fig: Figure, dpi: int = 150) -> bytes:
    """The figure as PNG without version and date: the same figure gives the same bytes."""
    stream = io.BytesIO()
    fig.savefig(stream, format="png", dpi=dpi, metadata={"Software": "hysgen"})
    return stream.getvalue()


def svg_bytes(fig: Figure) -> bytes:
    """The figure as SVG, text as outlines, element names salted, no date: the same figure gives the same bytes."""
    matplotlib.rcParams.update(_SETTINGS)
    stream = io.BytesIO()
    fig.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def data_uri(fig: Figure) -> str:
    """The figure as SVG inside a `data:` address: a page that shows it needs no other file."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg_bytes(fig)).decode()


def plain_number(value: float, _: int | None = None) -> str:
    """Label of a tick without an exponent where it is short. No lambda: figures are pickled."""
    return f"{value:.5f}".rstrip("0") if 1e-5 <= value < 1e-4 else f"{value:g}"


def three_digits(value: float, _: int | None = None) -> str:
    """Label of a tick between those of the decades."""
    return f"{value:.3g}"


def save(fig: Figure, path: Path) -> Path:
    """Write the figure as PNG, whole or not at all."""
    write_whole(path, png_bytes(fig))
    return path


def save_svg(fig: Figure, path: Path) -> Path:
    """Write the figure as SVG, whole or not at all."""
    write_whole(path, svg_bytes(fig))
    return path
