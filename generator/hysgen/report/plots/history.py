"""The history of a stage as a picture: change of each property in percent over its models."""

from __future__ import annotations

import numpy as np

from hysgen.report.plots.style import NOTE, Picture, figure
from hysgen.uncertainty.history import History


def changes(history: History) -> Picture:
    """Change from the first model, one line per property, and the limit."""
    fig = figure()
    axes = fig.add_subplot()
    places = np.arange(len(history.files))
    for trend in history.trends:
        if trend.percent is not None:
            values = np.asarray(trend.values)
            axes.plot(places, 100.0 * (values - values[0]) / abs(values[0]), marker=".", label=trend.what)
    for sign in (-1.0, 1.0):
        axes.axhline(sign * history.limit, color=NOTE, linestyle="--")
    axes.set_xticks(places, history.files, rotation=30, ha="right")
    axes.set_ylabel("change since the first model, %")
    axes.set_title("What moved?")
    fig.legend(loc="outside right center")
    worst = max((trend.percent or 0.0 for trend in history.trends), default=0.0)
    return Picture("history", "What moved?", f"Largest change {worst:.3g} % over {len(places)} models.", fig)
