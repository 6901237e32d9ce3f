"""Inputs of a comparison as bit patterns: random, smooth, edges of every kind, and any 32 bits at all."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.instance import Instance
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.model.terms import Drive, channels_of

Words = NDArray[np.uint32]
Floats32 = NDArray[np.float32]

CHUNK: Final = 1 << 16
Style = Callable[[np.random.Generator, int, int, tuple[np.float32, np.float32]], Words]


def quantities(model: Model) -> Mapping[str, tuple[np.float32, np.float32]]:
    """The range of each quantity that a generated function takes, in its unit."""
    numbers: Coefficients = coefficients(model)
    return {
        "displacement": (numbers.y_min_um, numbers.y_max_um),
        "reference": (numbers.y_min_um, numbers.y_max_um),
        "measured": (numbers.y_min_um, numbers.y_max_um),
        "voltage": (numbers.u_min_V, numbers.u_max_V),
        # Ranges of channels differ; this one is wider than most, so that they are left now and then.
        "channel": (np.float32(-10.0), np.float32(50.0)),
    }


def chunks(
    model: Model, style: str, arguments: Sequence[str], samples: int, seed: int, piece: int = CHUNK
) -> Iterator[list[Words]]:
    """`samples` of each argument, named by its quantity, in pieces: the bits of one column per argument.

    References are what random or smooth inputs would reach, or else hardly any would be met without clamping. Smooth
    measured displacements are the reply of a plant to the voltages beside them, so that there is something to learn.
    """
    rng = np.random.default_rng([seed, *style.encode()])
    ranges = quantities(model)
    reachable = style in ("random", "smooth")
    drawn = ["voltage" if quantity == "reference" and reachable else quantity for quantity in arguments]
    for first in range(0, samples, piece):
        n = min(piece, samples - first)
        columns = [STYLES[style](rng, first, n, ranges[quantity]) for quantity in drawn]
        if reachable and "reference" in arguments:
            y, u = (columns[arguments.index(quantity)] for quantity in ("displacement", "reference"))
            columns[arguments.index("reference")] = _reached(model, y, u)
        if style == "smooth" and "measured" in arguments:
            columns[arguments.index("measured")] = _reply(model, columns[arguments.index("voltage")], rng)
        yield columns


def _reached(model: Model, y: Words, u: Words) -> Words:
    """y(k+1) of the model at rest, from y under u."""
    at_rest = Instance(model, y.view(np.float32), np.zeros(y.size, dtype=np.float32))
    return at_rest.predict(y.view(np.float32), u.view(np.float32)).view(np.uint32)


def _reply(model: Model, u: Words, rng: np.random.Generator) -> Words:
    """What a plant answers that is the model but for 5 % of its gains, with noise of 1e-4 of the range."""
    weaker = model.consequents * [1.0, 0.95, 1.0]
    plant = dataclasses.replace(model, consequents=weaker)
    aux = {channel: np.zeros(u.size) for channel in channels_of(model.terms)}
    drive = Drive(u.view(np.float32).astype(np.float64), model.Ts_s, aux)
    y_um = simulate(plant, drive, 0.5 * (model.grid.y_min_um + model.grid.y_max_um)).y_um
    noise_um = 1e-4 * (model.grid.y_max_um - model.grid.y_min_um)
    return (y_um + rng.normal(0.0, noise_um, y_um.size)).astype(np.float32).view(np.uint32)


def _random(rng: np.random.Generator, first: int, n: int, limit: tuple[np.float32, np.float32]) -> Words:
    """Uniform over the range and 15 % of it beyond either end."""
    low, high = (float(end) for end in limit)
    beyond = 0.15 * (high - low)
    return rng.uniform(low - beyond, high + beyond, n).astype(np.float32).view(np.uint32)


def _smooth(rng: np.random.Generator, first: int, n: int, limit: tuple[np.float32, np.float32]) -> Words:
    """What a controller sees: slow sines with a little noise, held now and then."""
    low, high = (float(end) for end in limit)
    k = np.arange(first, first + n, dtype=np.float64)
    phase = 2.0 * np.pi * k / rng.uniform(200.0, 5000.0)
    swing = 0.5 + 0.45 * np.sin(phase) * np.cos(0.01 * phase)
    value = low + (high - low) * (swing + rng.normal(0.0, 1e-4, n))
    value[(k // 3000) % 5 == 4] = value[0]
    return np.asarray(value.astype(np.float32).view(np.uint32))


def _edges(rng: np.random.Generator, first: int, n: int, limit: tuple[np.float32, np.float32]) -> Words:
    """Zeros, denormals, the range's ends and their neighbours, huge values, infinities and NaN, in runs of 1 to 8."""
    special = _specials(limit)
    picked = rng.integers(0, special.size, n)
    held = np.maximum.accumulate(np.where(rng.random(n) < 0.7, np.arange(n), 0))
    ordinary = _random(rng, first, n, limit)
    return np.where(rng.random(n) < 0.6, special[picked[held]], ordinary)


def _patterns(rng: np.random.Generator, first: int, n: int, limit: tuple[np.float32, np.float32]) -> Words:
    """Any 32 bits."""
    return rng.integers(0, 1 << 32, n, dtype=np.uint32)


def _specials(limit: tuple[np.float32, np.float32]) -> Words:
    infinity = np.float32(np.inf)
    tiny = [2.0**-149, 2.0**-127, 2.0**-126, 2.0**-41, 2.0**-40, 2.0**-39]
    numbers = [0.0, *tiny, 1.0, 1e9, 3e38, np.inf, *limit, 0.5 * (float(limit[0]) + float(limit[1]))]
    around = [np.nextafter(end, way) for end in limit for way in (-infinity, infinity)]
    floats = np.array([*numbers, *around], dtype=np.float32)
    # NaN of either sign, quiet and signalling, with full and with empty payloads.
    nans = np.array([0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFBFFFFF, 0x7FFFFFFF], dtype=np.uint32)
    return np.concatenate([floats.view(np.uint32), (-floats).view(np.uint32), nans])


STYLES: Final[Mapping[str, Style]] = {"random": _random, "smooth": _smooth, "edges": _edges, "patterns": _patterns}
SHARES: Final[Mapping[str, float]] = {"random": 0.25, "smooth": 0.4, "edges": 0.2, "patterns": 0.15}
"""Part of the samples that each style gets; the smooth ones are the long run."""
