"""A picture with what goes around it: a name for its file, a title, and the words for those who do not see it."""

from __future__ import annotations

import base64
from dataclasses import dataclass

from matplotlib.figure import Figure

from hysgen.report.plots import style


@dataclass(frozen=True, eq=False)
class Picture:
    """name: of its file, without ending; title: what it answers; alt: what it shows, in words with its numbers."""

    name: str
    title: str
    alt: str
    figure: Figure

    @property
    def data_uri(self) -> str:
        """The picture as SVG inside a `data:` address, so that a page needs no other file."""
        return "data:image/svg+xml;base64," + base64.b64encode(style.svg_bytes(self.figure)).decode()
