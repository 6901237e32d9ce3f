"""For studies of the diagnosis: the names alone, and the error of one model beside them, without a whole diagnosis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.extension_forms import with_best_forms
from hysgen.diagnosis.ladder import fit_ladder
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.procedure import Naming, name_causes
from hysgen.fitting import FitSettings

__all__ = ["Extension", "Naming", "Prepared", "free_run_error", "name_causes", "prepare"]


def free_run_error(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str] = (), *, forms: bool = False
) -> NDArray[np.float64]:
    """Error in um, (n,), of the free run of the model with the extensions of `names`, fitted as a diagnosis does.

    forms: choose the forms of the extensions by cross-validation first.
    """
    settings = FitSettings()
    chosen = with_best_forms(prepared, extensions, names, settings) if forms else extensions
    return fit_ladder(prepared, chosen, names, settings).error_um
