"""A model on arrays, for scripts and notebooks: simulation and prediction in float64, the inverse in float32.

`Model.simulate`, `Model.predict` and `Model.inverse` are these functions.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.certify.certificates import certify
from hysgen.checking.host import Host
from hysgen.codegen import Options, generate
from hysgen.errors import CertificateError, ModelError
from hysgen.model import simulate as simulation
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.record.data import Record
from hysgen.record.segment import Segment

Floats = NDArray[np.float64]

REST_S, LEAST_REST = 0.05, 2000
"""Seconds, and samples at least, under the first voltage before a simulation without a starting point."""


BISECTIONS = 24
"""Steps that find a voltage to 1e-7 of the input range."""


def simulate(
    model: Model, u_V: ArrayLike, y0_um: float | None = None, channels: Mapping[str, ArrayLike] | None = None
) -> Floats:
    """Displacement in um, (n,), of a free run under the voltages u_V, (n,): y(k) before u(k) acts.

    y0_um: displacement at sample 0; by default that at rest under u(0). channels: of the model's terms.
    Raises ModelError for an input that is no series of finite numbers, or for a missing channel.
    """
    u = series(u_V, "u_V")
    given = {name: series(values, name, u.size) for name, values in (channels or {}).items()}
    _need_channels(model, given)
    if y0_um is None:
        y0_um = _rest_um(model, float(u[0]), {name: float(values[0]) for name, values in given.items()})
    return simulation.simulate(model, Drive(u, model.Ts_s, given), y0_um).y_um


def predict(model: Model, y_um: ArrayLike, u_V: ArrayLike, channels: Mapping[str, ArrayLike] | None = None) -> Floats:
    """One step ahead, in um, (n,): element k is the prediction of y(k) from the measured y(k-1) and u(k-1).

    Element 0 is y(0). Raises ModelError as `simulate` does.
    """
    u, y = series(u_V, "u_V"), series(y_um, "y_um")
    given = {name: series(values, name, u.size) for name, values in (channels or {}).items()}
    _need_channels(model, given)
    record = Record.from_segments([Segment("0", u, series(y, "y_um", u.size), given)], model.Ts_s)
    return simulation.one_step(model, record)[0].y_um


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
    instance = host.instance(float(measured[0]), _rest_voltage(model, float(measured[0])))
    words = [np.ascontiguousarray(part, dtype=np.float32).view(np.uint32) for part in (measured[:-1], wanted[1:])]
    return host.run("inverse", instance, words)[0].view(np.float32).astype(np.float64)


def _rest_um(model: Model, u_V: float, channels: Mapping[str, float]) -> float:
    """Displacement at rest under a voltage."""
    samples = max(LEAST_REST, round(REST_S / model.Ts_s))
    held = {name: np.full(samples, value) for name, value in channels.items()}
    middle = 0.5 * (model.grid.y_min_um + model.grid.y_max_um)
    return float(simulation.simulate(model, Drive(np.full(samples, u_V), model.Ts_s, held), middle).y_um[-1])


def _rest_voltage(model: Model, y_um: float) -> float:
    """Voltage under which the model rests at y, by bisection; an end of the input range for a y beyond it."""
    low_V, high_V = model.u_min_V, model.u_max_V
    rising = _rest_um(model, high_V, {}) > _rest_um(model, low_V, {})
    for _ in range(BISECTIONS):
        middle_V = 0.5 * (low_V + high_V)
        if (_rest_um(model, middle_V, {}) < y_um) == rising:
            low_V = middle_V
        else:
            high_V = middle_V
    return 0.5 * (low_V + high_V)


def series(values: ArrayLike, name: str, size: int | None = None) -> Floats:
    """Values as float64, (n,); a column (n, 1) is taken. Raises ModelError if they are no finite numbers."""
    try:
        array = np.squeeze(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError) as fault:
        raise ModelError(f"{name}: holds no numbers ({fault}); give an array of shape (n,)") from fault
    array = np.atleast_1d(array)
    if array.ndim != 1 or array.size < 2:
        raise ModelError(f"{name}: has shape {array.shape}; give an array of shape (n,), n >= 2")
    if size is not None and array.size != size:
        raise ModelError(f"{name}: has {array.size} samples, the voltage {size}; give as many")
    if not np.isfinite(array).all():
        row = int(np.argmin(np.isfinite(array)))
        raise ModelError(f"{name}: index {row} is {array[row]}; give finite numbers")
    return array


def _need_channels(model: Model, given: Mapping[str, Floats]) -> None:
    for term in model.terms:
        channel = getattr(term, "channel", None)
        if isinstance(channel, str) and channel not in given:
            raise ModelError(f"{model.name}: needs the channel {channel}; give channels={{{channel!r}: values}}")
