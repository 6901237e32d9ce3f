"""hysgen: from measured records of a piezo stage to verified float32 C.

    import hysgen

    record = hysgen.load_record("record.csv")
    study = hysgen.diagnose(record)
    hysgen.generate(study.model).write("firmware/stage")

The names of `hysgen.api`, loaded when the first of them is used.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

# For matrices as small as these, BLAS threads cost up to ten times the work on a busy machine, and their number changes
# the last bits of results. A number set by the user is kept.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

__all__ = [
    "Columns",
    "Cost",
    "DiagnoseSettings",
    "FitSettings",
    "Generated",
    "HysgenError",
    "Model",
    "Options",
    "Record",
    "RecordWarning",
    "Report",
    "Scores",
    "Study",
    "cost",
    "diagnose",
    "fit",
    "generate",
    "load_model",
    "load_record",
    "save_model",
    "score",
    "verify",
]

if TYPE_CHECKING:
    from hysgen.api import (
        Columns,
        Cost,
        DiagnoseSettings,
        FitSettings,
        Generated,
        HysgenError,
        Model,
        Options,
        Record,
        RecordWarning,
        Report,
        Scores,
        Study,
        cost,
        diagnose,
        fit,
        generate,
        load_model,
        load_record,
        save_model,
        score,
        verify,
    )


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("hysgen.machine.installed").version()
    if name in __all__:
        return getattr(importlib.import_module("hysgen.api"), name)
    raise AttributeError(f"module 'hysgen' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
