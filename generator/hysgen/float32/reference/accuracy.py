"""Largest difference between the float32 reference and the float64 model in one step, over the whole range.

    predict    f32(y, u) minus sum_l p_l(y) (q_l1 y + q_l2 u + q_l3) + sum_j theta_j phi_j in float64
    inverse    u of Eq. (11) in float32 minus u in float64, for y(k+1) that an input in range reaches
    round trip predict(inverse) - y(k+1), both in float32

Both models get the same float32 inputs and the same term states, those of the float32 mirrors after a random run; the
difference is that of one step's arithmetic. Limiters and delay are omitted: u is the input after them. With responses
of the stage (hysteresis, creep, modes), w is in place of u, and the responses add what they leave over whole runs:

    path       w of the float32 path minus w in float64, from rest along random ramps; |b| times that is part of predict
    residual   w' of the inverse of the path minus the wanted w, in float32; |b| times that is part of the round trip

`python -m hysgen.float32.reference.accuracy MODEL...` prints the figures.
"""

import argparse
import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.rounding import ProvedErrors, proved_errors
from hysgen.machine.reproducible import drawn, product
from hysgen.model.file import load_model
from hysgen.model.float32_arithmetic import Floats32
from hysgen.model.model import Model
from hysgen.model.path import applied
from hysgen.model.regression import memberships

Floats = NDArray[np.float64]

LANES: Final = 1 << 16
WARM_UP: Final = 20
PATH_LANES: Final = 256
PATH_SAMPLES: Final = 256


@dataclass(frozen=True)
class Accuracy:
    """Largest absolute differences over `samples` pairs (y, u); inverse and round trip are 0 without an inverse.

    path, residual: differences of w, in its unit; 0 without responses of the stage. These are found, not bounds;
    proved: bounds of the rules, where there are any.
    """

    samples: int
    predict_um: float
    inverse_V: float
    predict_of_inverse_um: float
    path: float = 0.0
    residual: float = 0.0
    proved: ProvedErrors | None = None


def accuracy(model: Model, samples: int, *, inverse: bool = True, seed: int = 1) -> Accuracy:
    """The differences over pairs (y, u): half on a grid of both ranges, limits included, half uniformly distributed."""
    bare = model.behind_path
    worst = np.zeros(3)
    for y, u in _pairs(bare, samples, seed):
        instance = _warm(bare, y.size, seed)
        worst = np.maximum(worst, _step_errors(bare, instance, y, u, inverse))
    path, residual = _path_errors(model, seed, inverse) if model.responds else (0.0, 0.0)
    steepest = float(np.abs(model.consequents[:, 1]).max())
    worst[0] += steepest * path
    worst[2] += steepest * residual
    predict_um, inverse_V, again_um = worst.tolist()
    bounds = proved_errors(model, inverse=inverse)
    return Accuracy(samples, predict_um, inverse_V, again_um, path, residual, bounds)


def _path_errors(model: Model, seed: int, inverse: bool) -> tuple[float, float]:
    """Largest |w - w in float64| and, where no limit acts, |w' - w| of the inverse, over PATH_LANES random runs.

    The commands are ramps between random levels of the range; the levels of a lane are 1 to 64 samples apart.
    """
    rng = np.random.default_rng(seed + 2)
    apart = 4 ** (np.arange(PATH_LANES) % 4)
    levels = drawn(rng, model.u_min_V, model.u_max_V, PATH_LANES * (PATH_SAMPLES + 2)).reshape(PATH_LANES, -1)
    k = np.arange(PATH_SAMPLES)
    lanes, places = np.arange(PATH_LANES)[:, None], k // apart[:, None]
    before, after = levels[lanes, places], levels[lanes, places + 1]
    u = (before + (after - before) * (k / apart[:, None] - places)).astype(np.float32)
    start = Instance(model, np.full(PATH_LANES, np.float32(model.grid.y_min_um)), u[:, 0])
    forward, backward = start.inputs, copy.deepcopy(start.inputs)
    w, residual = np.empty(u.shape, dtype=np.float32), 0.0
    for sample in range(PATH_SAMPLES):
        w[:, sample] = forward.apply(u[:, sample])
        if inverse:
            found = backward.invert(w[:, sample])
            missed = np.abs(found.w - w[:, sample].astype(np.float64))
            limited = found.unreachable | (found.astray != 0.0)
            residual = max(residual, float(np.where(limited, 0.0, missed).max()))
    exact = [applied(model.blocks, lane.astype(np.float64), model.Ts_s, model.w_range) for lane in u]
    return float(np.abs(w - np.array(exact)).max()), residual


def _step_errors(model: Model, instance: Instance, y: Floats32, u: Floats32, inverse: bool) -> Floats:
    """(3,) the largest difference over the lanes, in the order of the fields of `Accuracy`."""
    exact_base, exact_gain = _affine(model, instance, y)
    forward, backward, again = (copy.deepcopy(instance) for _ in range(3))
    y_next = forward.predict(y, u)
    predicted = np.abs(y_next - (exact_base + exact_gain * u)).max()
    if not inverse:
        return np.array([predicted, 0.0, 0.0])
    # The inverse does not correct the terms by the innovation, so its y(k+1) differs from that of predict.
    base, gain = _affine(model, instance, y, corrected=False)
    wanted = (base + gain * u).astype(np.float32)
    u_back = backward.inverse(y, wanted)
    exact_back = np.clip((wanted - base) / gain, float(instance.numbers.u_min_V), float(instance.numbers.u_max_V))
    again.y_um = y
    reached = again.simulate(u_back)
    inside = (u_back > instance.numbers.u_min_V) & (u_back < instance.numbers.u_max_V)
    missed = np.abs((reached - wanted.astype(np.float64))[inside]).max(initial=0.0)
    return np.array([predicted, np.abs(u_back - exact_back).max(), missed])


def _affine(model: Model, instance: Instance, y: Floats32, *, corrected: bool = True) -> tuple[Floats, Floats]:
    """f(y, 0) [um] and b(y) [um/V] in float64, (lanes,) each, with the term states of `instance`."""
    y64 = y.astype(np.float64)
    p = memberships(y64, model.grid)
    q1, q2, q3 = model.consequents.T
    base = product(p, q1) * model.grid.clamp(y64) + product(p, q3)
    terms = copy.deepcopy(instance.terms)
    if corrected:
        for term in terms:
            term.correct(y - instance.y_um)
    phi = [regressor for term in terms for regressor in term.regressors()]
    for theta, regressor in zip(model.weights, phi, strict=True):
        base = base + theta * regressor
    return base, product(p, q2)


def _pairs(model: Model, samples: int, seed: int) -> Iterator[tuple[Floats32, Floats32]]:
    rng = np.random.default_rng(seed)
    side = max(2, round((samples / 2) ** 0.5))
    low, high = np.float32(model.grid.y_min_um), np.float32(model.grid.y_max_um)
    first, last = np.float32(model.u_min_V), np.float32(model.u_max_V)
    grid = np.meshgrid(np.linspace(low, high, side), np.linspace(first, last, side))
    random = [
        drawn(rng, *ends, samples - side * side) for ends in ((float(low), float(high)), (float(first), float(last)))
    ]
    y, u = (np.concatenate([part.ravel(), drawn]).astype(np.float32) for part, drawn in zip(grid, random, strict=True))
    for begin in range(0, y.size, LANES):
        yield y[begin : begin + LANES], u[begin : begin + LANES]


def _warm(model: Model, lanes: int, seed: int) -> Instance:
    """An instance whose lanes have the term states of independent random runs of WARM_UP samples."""
    rng = np.random.default_rng(seed + 1)
    instance = Instance(model, np.full(lanes, np.float32(model.grid.y_min_um)), np.zeros(lanes, dtype=np.float32))
    for _ in range(WARM_UP if model.terms else 0):
        if instance.channels:
            instance.aux([drawn(rng, 0.0, 1.0, lanes).astype(np.float32) for _ in instance.channels])
        instance.simulate(drawn(rng, model.u_min_V, model.u_max_V, lanes).astype(np.float32))
    return instance


def main() -> None:
    """Print the differences of the models on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("--samples", type=int, default=4_000_000)
    arguments = parser.parse_args()
    for name in arguments.models:
        errors = accuracy(load_model(name), arguments.samples)
        print(
            f"{name}: {errors.samples} samples, float32 against float64: predict {errors.predict_um:.3g} um, "
            f"inverse {errors.inverse_V:.3g} V, predict(inverse) {errors.predict_of_inverse_um:.3g} um; "
            f"path {errors.path:.3g}, its inverse {errors.residual:.3g}; proved of the rules: {errors.proved}"
        )


if __name__ == "__main__":
    main()
