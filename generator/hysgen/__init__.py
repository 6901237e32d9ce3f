"""hysgen: from measured records of a piezo stage to verified float32 C.

    import hysgen

    record = hysgen.load_record("record.csv")
    study = hysgen.diagnose(record)
    hysgen.generate(study.model).write("firmware/stage")

The functions and types are those of `hysgen.api`, loaded when they are first used.
"""

from __future__ import annotations

import importlib
import os
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

# The matrices here are small: threads of the BLAS cost up to ten times the work on a busy machine, and how many there
# are changes last bits. Who has set their number, or imported NumPy before, keeps what is.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

from hysgen.display import drawn_by  # noqa: E402

__version__ = "0.1.0"

# Pictures stand behind results in the house: results know that there is a door, the package knows where it leads.
drawn_by("hysgen.plots.results")

_EXPORTED = (
    "Columns",
    "Cost",
    "DiagnoseSettings",
    "FitSettings",
    "Generated",
    "HysgenError",
    "Model",
    "Options",
    "Record",
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
)

__all__ = list(_EXPORTED)

if TYPE_CHECKING:
    from hysgen.api import *  # noqa: F403


class _Package(ModuleType):
    """The package with its functions in front: `hysgen.fit` is the function, `from hysgen.fit import ...` the room.

    Importing a room would bind its module to the same name; the setter below lets that pass by.
    """

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_EXPORTED})


def _exported(name: str) -> property:
    def found(_: ModuleType) -> Any:
        return getattr(importlib.import_module("hysgen.api"), name)

    return property(found, lambda _, __: None)


for _name in _EXPORTED:
    setattr(_Package, _name, _exported(_name))
sys.modules[__name__].__class__ = _Package
