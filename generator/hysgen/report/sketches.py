"""The two small pictures of a cause: as SVG for the page and the docs, as dots for the terminal."""

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.remedy import Sketch
from hysgen.report import BLUE, VERMILION

Floats = NDArray[np.float64]

ACTING, FREE = VERMILION, BLUE
"""Colours with the cause and without it: those of the paper's model and of the extended one."""

WIDTH, HEIGHT, GAP = 150.0, 64.0, 24.0
COLUMNS, LINES = 26, 4
"""Letters of a picture in the terminal; each has two by four dots."""

DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bits of a Braille letter by row and column."""


def svg(sketch: Sketch, name: str, head: str = "") -> str:
    """Both pictures side by side on one scale; the letters have the colour of the text around. head: attributes."""
    panels = []
    for at, label, shown, behind, colour in (
        (0.0, f"with {name}", sketch.acting, sketch.free, ACTING),
        (WIDTH + GAP, f"without {name}", sketch.free, sketch.acting, FREE),
    ):
        panels.append(
            f'<text x="{at:g}" y="10">{label}</text><rect x="{at:g}" y="14" width="{WIDTH:g}" '
            f'height="{HEIGHT + 2.0:g}" fill="none" stroke="#9995"/>'
            + _line(at, sketch.x, behind, "#9998", 0.8)
            + _line(at, sketch.x, shown, colour, 1.6)
        )
    words = f"{sketch.words}; {sketch.height_um:.3g} um high"
    return (
        f'<svg {head}viewBox="0 0 {2.0 * WIDTH + GAP:g} 96" role="img" aria-label="{name}: {words}" '
        f'font-family="sans-serif" font-size="10.5" fill="currentColor">{"".join(panels)}'
        f'<text x="0" y="92">{words}</text></svg>'
    )


def _line(at: float, x: Floats, y: Floats, colour: str, width: float) -> str:
    across, down = at + 2.0 + (WIDTH - 4.0) * x, np.clip(17.0 + (HEIGHT - 4.0) * (1.0 - y), 15.0, 15.0 + HEIGHT)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
    return f'<polyline points="{points}" stroke="{colour}" stroke-width="{width}" fill="none" stroke-linejoin="round"/>'


def dotted(sketch: Sketch, name: str) -> list[str]:
    """Both pictures side by side in lines of Braille letters."""
    pictures = [_dots(sketch.x, y) for y in (sketch.acting, sketch.free)]
    head = f"{f'with {name}':{COLUMNS}}   without"
    return [head, *("   ".join(pair) for pair in zip(*pictures, strict=True))]


def _dots(x: Floats, y: Floats) -> list[str]:
    rows, columns = 4 * LINES, 2 * COLUMNS
    fine = np.linspace(0.0, len(x) - 1.0, 8 * len(x) + 8 * columns)
    across, up = (np.interp(fine, np.arange(len(x)), values) for values in (x, y))
    inside = (up >= 0.0) & (up <= 1.0)
    cells = np.zeros((LINES, COLUMNS), dtype=np.int64)
    j = np.round(across[inside] * (columns - 1)).astype(np.intp)
    i = np.round((1.0 - up[inside]) * (rows - 1)).astype(np.intp)
    np.bitwise_or.at(cells, (i // 4, j // 2), DOTS[i % 4, j % 2])
    return ["".join(chr(0x2800 + int(cell)) for cell in line) for line in cells]
