"""hysgen: from measured records of a piezo stage to verified float32 C.

    import hysgen

    record = hysgen.load_record("record.csv")
    study = hysgen.diagnose(record)
    hysgen.generate(study.model).write("firmware/stage")

The names of `hysgen.api`, loaded when the first of them is used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__all__ = [
    "Columns",
    "Cost",
    "DiagnoseSettings",
    "FitSettings",
    "Generated",
    "HysgenError",
    "HysteresisRegressor",
    "Model",
    "Options",
    "Record",
    "RecordWarning",
    "Report",
    "Scores",
    "Study",
    "certificates",
    "connect",
    "cost",
    "demo_record",
    "describe",
    "diagnose",
    "diff",
    "firmware_files",
    "fit",
    "generate",
    "history",
    "image",
    "inspect",
    "load_model",
    "load_record",
    "page",
    "prove",
    "refit",
    "rivals",
    "save_model",
    "schema",
    "score",
    "verify",
    "write_export",
]

if TYPE_CHECKING:
    from hysgen.api import (
        Columns,
        Cost,
        DiagnoseSettings,
        FitSettings,
        Generated,
        HysgenError,
        HysteresisRegressor,
        Model,
        Options,
        Record,
        RecordWarning,
        Report,
        Scores,
        Study,
        certificates,
        connect,
        cost,
        demo_record,
        describe,
        diagnose,
        diff,
        firmware_files,
        fit,
        generate,
        history,
        image,
        inspect,
        load_model,
        load_record,
        page,
        prove,
        refit,
        rivals,
        save_model,
        schema,
        score,
        verify,
        write_export,
    )


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("hysgen.machine.installed").version()
    if name in __all__:
        return getattr(importlib.import_module("hysgen.api"), name)
    raise AttributeError(f"module 'hysgen' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", "__doc__", "__all__"})
