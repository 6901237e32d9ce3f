"""A budget file: cost on the target of the C of some models, kept under version control, and changes against it.

{"compiler": ..., "models": {model: {function: {"cycles": .., "code_bytes": .., "stack_bytes": ..},
"data": {"struct_bytes": .., "constant_bytes": ..}}}}. A figure exceeds the budget if it
grows by more than TOLERANCE. A figure that shrinks by more than TOLERANCE is reported as well, so that the budget can
be tightened and a later growth is noticed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.errors import HysgenError
from hysgen.machine.files import write_whole

TOLERANCE: Final = 0.02

Figures = Mapping[str, Mapping[str, int]]
"""Function, "all" or "data" -> name of the figure -> its value."""


@dataclass(frozen=True)
class FigureChange:
    """A figure that differs from the budget by more than TOLERANCE; None: the figure is missing on that side."""

    model: str
    function: str
    figure: str
    budget: int | None
    found: int | None

    @property
    def exceeds(self) -> bool:
        """Whether the figure is above the budget, or missing on either side."""
        return self.budget is None or self.found is None or self.found > self.budget

    def __str__(self) -> str:
        figure = f"{self.model}, {self.function}: {self.figure.replace('_', ' ')}"
        if self.budget is None:
            return f"NOT IN THE BUDGET: {figure} {self.found}"
        if self.found is None:
            return f"IN THE BUDGET ONLY: {figure} {self.budget}"
        share = 100.0 * (self.found - self.budget) / max(self.budget, 1)
        verdict = "OVER BUDGET" if self.exceeds else "below budget, tighten it with --update-budget"
        return f"{verdict}: {figure} {self.found}, budget {self.budget} ({share:+.1f} %)"


def read(path: Path, model: str) -> Figures:
    """The budget of one model. Raises HysgenError if the file is missing, not a budget file, or lacks the model."""
    models = _models(path)
    if model not in models:
        raise HysgenError(f"{path}: no budget for {model}; write it with --update-budget")
    budget: Figures = models[model]
    return budget


def update(path: Path, model: str, figures: Figures, compiler: str) -> None:
    """Write the figures of one model to the file, created if missing; other models are kept."""
    models = dict(_models(path)) if path.exists() else {}
    models[model] = figures
    content = {"compiler": compiler, "models": dict(sorted(models.items()))}
    write_whole(path, json.dumps(content, indent=2) + "\n")


def changes(model: str, budget: Figures, measured: Figures) -> list[FigureChange]:
    """Figures that differ from the budget by more than TOLERANCE, in the order of `measured`."""
    different = []
    for function in [*measured, *(name for name in budget if name not in measured)]:
        old, new = budget.get(function, {}), measured.get(function, {})
        for figure in [*new, *(name for name in old if name not in new)]:
            was, now = old.get(figure), new.get(figure)
            if was is None or now is None or abs(now - was) > TOLERANCE * was:
                different.append(FigureChange(model, function, figure, was, now))
    return different


def _models(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise HysgenError(f"{path}: {fault.strerror}; write it with --update-budget") from None
    except ValueError:
        content = None
    if not isinstance(content, dict) or not isinstance(content.get("models"), dict):
        raise HysgenError(f"{path}: not a budget file; write it anew with --update-budget")
    models: Mapping[str, Any] = content["models"]
    return models
