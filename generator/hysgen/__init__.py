"""hysgen: from measured records of a piezo stage to verified float32 C.

    import hysgen

    record = hysgen.load_record("record.csv")
    study = hysgen.diagnose(record)
    hysgen.generate(study.model).write("firmware/stage")

A name imports the module that holds it when it is used for the first time.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hysgen import upward

if TYPE_CHECKING:
    from hysgen.api import (
        Generated,
        certificates,
        connect,
        cost,
        describe,
        diagnose,
        diff,
        firmware_files,
        fit,
        generate,
        history,
        image,
        inspect,
        page,
        prove,
        refit,
        rivals,
        schema,
        score,
        verify,
        write_export,
    )
    from hysgen.checking.bits.report import Report
    from hysgen.checking.cost import Cost
    from hysgen.codegen import Options
    from hysgen.diagnosis import DiagnoseSettings
    from hysgen.diagnosis.evaluation import Study
    from hysgen.errors import HysgenError, RecordWarning
    from hysgen.estimator import HysteresisRegressor
    from hysgen.fitting import FitSettings
    from hysgen.model.file import load_model, save_model
    from hysgen.model.model import Model
    from hysgen.model.scores import Scores
    from hysgen.record import Columns, Record, load_record
    from hysgen.record.bundled import demo_record

_HOMES = {
    "Columns": "record",
    "Cost": "checking.cost",
    "DiagnoseSettings": "diagnosis",
    "FitSettings": "fitting",
    "Generated": "api",
    "HysgenError": "errors",
    "HysteresisRegressor": "estimator",
    "Model": "model.model",
    "Options": "codegen",
    "Record": "record",
    "RecordWarning": "errors",
    "Report": "checking.bits.report",
    "Scores": "model.scores",
    "Study": "diagnosis.evaluation",
    "certificates": "api",
    "connect": "api",
    "cost": "api",
    "demo_record": "record.bundled",
    "describe": "api",
    "diagnose": "api",
    "diff": "api",
    "firmware_files": "api",
    "fit": "api",
    "generate": "api",
    "history": "api",
    "image": "api",
    "inspect": "api",
    "load_model": "model.file",
    "load_record": "record",
    "page": "api",
    "prove": "api",
    "refit": "api",
    "rivals": "api",
    "save_model": "model.file",
    "schema": "api",
    "score": "api",
    "verify": "api",
    "write_export": "api",
}
"""Module of each public name."""

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from hysgen.machine.files import version

        return version()
    if name in _HOMES:
        return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'hysgen' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", "__doc__", "__all__"})


def _draw() -> Callable[..., Any]:
    from hysgen.report.plots.results import draw

    return draw


def _inverse() -> Callable[..., Any]:
    from hysgen.checking.host import inverse

    return inverse


upward.draw, upward.inverse = _draw, _inverse
