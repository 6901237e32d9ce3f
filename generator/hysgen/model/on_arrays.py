"""A model on arrays, for scripts and notebooks: `Model.simulate` and `Model.predict`, in float64."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import ModelError
from hysgen.model import simulate as simulation
from hysgen.model.disturbances import Drive
from hysgen.record.data import Record
from hysgen.record.segment import Segment

if TYPE_CHECKING:
    from hysgen.model.model import Model

Floats = NDArray[np.float64]

REST_S, LEAST_REST = 0.05, 2000
"""Seconds, and samples at least, under the first voltage before a simulation without a starting point."""


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
        y0_um = rest_um(model, float(u[0]), {name: float(values[0]) for name, values in given.items()})
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


def rest_um(model: Model, u_V: float, channels: Mapping[str, float]) -> float:
    """Displacement at rest under a voltage."""
    samples = max(LEAST_REST, round(REST_S / model.Ts_s))
    held = {name: np.full(samples, value) for name, value in channels.items()}
    middle = 0.5 * (model.grid.y_min_um + model.grid.y_max_um)
    return float(simulation.simulate(model, Drive(np.full(samples, u_V), model.Ts_s, held), middle).y_um[-1])


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
