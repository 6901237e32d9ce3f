"""The inverse of a model on arrays: `Model.inverse`, in float32 by the generated C."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.certify.certificates import certify
from hysgen.checking.host import Host
from hysgen.codegen import Options, generate
from hysgen.errors import CertificateError, ModelError
from hysgen.model.model import Model
from hysgen.model.on_arrays import rest_um, series

Floats = NDArray[np.float64]

BISECTIONS = 24
"""Steps that find a voltage to 1e-7 of the input range."""


def inverse(model: Model, reference_um: ArrayLike, y_um: ArrayLike | None = None) -> Floats:
    """Voltage in V, (n - 1,), that takes y(k) to reference(k + 1): Eq. (11) in float32, in the generated C.

    reference_um: (n,) wanted displacement. y_um: (n,) measured displacement; by default the reference itself, which is
    feed-forward. Raises CertificateError for a model without a certified inverse, BuildError without a compiler.
    """
    wanted = series(reference_um, "reference_um")
    measured = wanted if y_um is None else series(y_um, "y_um", wanted.size)
    if not certify(model).inverse_holds:
        raise CertificateError(f"{model.name}: the inverse is not certified; `hysgen describe` says why")
    host = Host(model.name, generate(model, Options(inverse=True)))
    if host.channels:
        raise ModelError(f"{model.name}: its inverse needs the channels {host.channels}; use the C instead")
    instance = host.instance(float(measured[0]), rest_voltage(model, float(measured[0])))
    words = [np.ascontiguousarray(part, dtype=np.float32).view(np.uint32) for part in (measured[:-1], wanted[1:])]
    return host.run("inverse", instance, words)[0].view(np.float32).astype(np.float64)


def rest_voltage(model: Model, y_um: float) -> float:
    """Voltage under which the model rests at y, by bisection; an end of the input range for a y beyond it."""
    low_V, high_V = model.u_min_V, model.u_max_V
    rising = rest_um(model, high_V, {}) > rest_um(model, low_V, {})
    for _ in range(BISECTIONS):
        middle_V = 0.5 * (low_V + high_V)
        if (rest_um(model, middle_V, {}) < y_um) == rising:
            low_V = middle_V
        else:
            high_V = middle_V
    return 0.5 * (low_V + high_V)
