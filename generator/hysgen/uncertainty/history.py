"""The history of a stage: its models over time, the change of each physical property, and a limit for a script.

A folder holds the model files of one stage, of one structure, one for each refit, in the order of the file names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.errors import HysgenError
from hysgen.fitting.refit import loop_frequencies, physics, require_same_structure
from hysgen.model.file import load_model
from hysgen.model.model import Model

LIMIT_PERCENT: Final = 5.0


@dataclass(frozen=True)
class Trend:
    """A property over all models. percent: largest change from the first model, None where that is zero."""

    what: str
    unit: str
    values: tuple[float, ...]

    @property
    def percent(self) -> float | None:
        first = self.values[0]
        return max((100.0 * abs(v - first) / abs(first) for v in self.values), default=0.0) if first else None


@dataclass(frozen=True)
class History:
    """Models by file name, in their order, and the trends of their properties. limit: largest change in percent."""

    files: tuple[str, ...]
    trends: tuple[Trend, ...]
    limit: float

    @property
    def exceeded(self) -> tuple[Trend, ...]:
        """Trends beyond the limit."""
        return tuple(trend for trend in self.trends if trend.percent is not None and trend.percent > self.limit)

    @property
    def drift_um(self) -> float:
        """Largest change of the displacement at rest since the first model, a contribution to an uncertainty."""
        rest = [trend.values for trend in self.trends if trend.what.startswith("at rest")]
        return max((abs(value - values[0]) for values in rest for value in values), default=0.0)

    def rows(self) -> list[list[str]]:
        """Cells: property, unit, first, last, largest change."""
        return [
            [
                trend.what,
                trend.unit,
                f"{trend.values[0]:.5g}",
                f"{trend.values[-1]:.5g}",
                "" if trend.percent is None else f"{trend.percent:.2f} %",
                "LIMIT" if trend in self.exceeded else "",
            ]
            for trend in self.trends
        ]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "files": list(self.files),
            "limit_percent": self.limit,
            "exceeded": [trend.what for trend in self.exceeded],
            "drift_um": self.drift_um,
            "trends": [{**vars(t), "values": list(t.values), "percent": t.percent} for t in self.trends],
        }


def history(folder: Path, limit: float = LIMIT_PERCENT) -> History:
    """The history of the models in a folder (*.json).

    Raises HysgenError if there are fewer than two models, and ModelError if their structures differ.
    """
    paths = sorted(path for path in folder.glob("*.json") if path.name != "MANIFEST.json")
    if len(paths) < 2:
        raise HysgenError(f"{folder}: holds {len(paths)} model files; a history needs two or more, *.json")
    return trends([(path.name, load_model(path)) for path in paths], limit)


def trends(models: Sequence[tuple[str, Model]], limit: float = LIMIT_PERCENT) -> History:
    """The trends of models, each with the name of its file; the first model sets the frequencies of the loops."""
    first = models[0][1]
    for _, model in models[1:]:
        require_same_structure(first, model)
    frequencies = loop_frequencies(first)
    properties = [physics(model, frequencies) for _, model in models]
    rows = tuple(
        Trend(what, unit, tuple(values[place][2] for values in properties))
        for place, (what, unit, _) in enumerate(properties[0])
    )
    return History(tuple(name for name, _ in models), rows, limit)
