"""hysgen: from measured records of a piezo stage to verified float32 C.

    import hysgen

    record = hysgen.load_record("record.csv")
    study = hysgen.diagnose(record)
    hysgen.generate(study.model).write("firmware/stage")

A name imports the module that holds it when it is used for the first time.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hysgen import upward

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOMES = {name: module for module, name in re.findall(r"^from (\S+) import (\w+)", _STUB, re.MULTILINE)}
"""Module of each public name."""

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from hysgen.machine.files import version

        return version()
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'hysgen' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", "__doc__", "__all__"})


def _draw() -> Callable[..., Any]:
    from hysgen.report.plots.results import draw

    return draw


def _inverse() -> Callable[..., Any]:
    from hysgen.checking import inverse

    return inverse


upward.draw, upward.inverse = _draw, _inverse
