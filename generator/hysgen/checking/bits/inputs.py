"""Input styles of a comparison, as bit patterns: random, smooth, edge values, and arbitrary 32-bit patterns."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.instance import Instance
from hysgen.model.disturbances import Drive, channels_of
from hysgen.model.model import Model
from hysgen.model.path import applied
from hysgen.model.simulate import simulate

Words = NDArray[np.uint32]
Floats32 = NDArray[np.float32]
Range = tuple[np.float32, np.float32]

CHUNK: Final = 1 << 16
WEAKER: Final = 0.95
"""Gains of the weaker stage, as a share of the model's gains."""
SENSOR_NOISE: Final = 1e-4
"""rms noise of the weaker stage's sensor, as a share of the displacement range."""

Style = Callable[[np.random.Generator, int, int, Range], Words]
"""(rng, index of the first sample, samples, range of the quantity) -> bits, (samples,)."""


def ranges(model: Model) -> Mapping[str, Range]:
    """The range of each quantity that a generated function takes, in its unit."""
    numbers: Coefficients = coefficients(model)
    return {
        "displacement": (numbers.y_min_um, numbers.y_max_um),
        "reference": (numbers.y_min_um, numbers.y_max_um),
        "measured": (numbers.y_min_um, numbers.y_max_um),
        "voltage": (numbers.u_min_V, numbers.u_max_V),
        # Wider than the range of most auxiliary channels, so that their clamps act now and then.
        "channel": (np.float32(-10.0), np.float32(50.0)),
    }


def chunks(
    model: Model, style: str, quantities: Sequence[str], samples: int, seed: int, chunk: int = CHUNK
) -> Iterator[list[Words]]:
    """`samples` of each quantity in chunks: the bits of one column per quantity.

    In the random and smooth styles a reference is the model's own next displacement under a random or smooth voltage: a
    reference drawn on its own would nearly always be clamped. A smooth measured displacement is the output of the
    weaker stage under the voltage column, so that the learner has a parameter error to correct.
    """
    rng = np.random.default_rng([seed, *style.encode()])
    range_of = ranges(model)
    reachable = style in ("random", "smooth")
    drawn = ["voltage" if quantity == "reference" and reachable else quantity for quantity in quantities]
    for first in range(0, samples, chunk):
        n = min(chunk, samples - first)
        columns = [STYLES[style](rng, first, n, range_of[quantity]) for quantity in drawn]
        if reachable and "reference" in quantities:
            y, u = (columns[quantities.index(quantity)] for quantity in ("displacement", "reference"))
            columns[quantities.index("reference")] = _next_displacement(model, y, u)
        if style == "smooth" and "measured" in quantities:
            u = columns[quantities.index("voltage")]
            columns[quantities.index("measured")] = weaker_stage(model, u, rng)
        yield columns


def weaker_stage(model: Model, u: Words, rng: np.random.Generator) -> Words:
    """Measured displacement of a plant that is the model with gains WEAKER times as large, at rest in mid-range.

    u: bits of u(k) in V, (n,). Returns the bits of y(k) in um, (n,), with normal noise of SENSOR_NOISE of the range.
    """
    low, high = model.grid.y_min_um, model.grid.y_max_um
    plant = dataclasses.replace(model, consequents=model.consequents * [1.0, WEAKER, 1.0])
    aux = {channel: np.zeros(u.size) for channel in channels_of(model.terms)}
    drive = Drive(u.view(np.float32).astype(np.float64), model.Ts_s, aux)
    y_um = simulate(plant, drive, 0.5 * (low + high)).y_um
    noise_um = SENSOR_NOISE * (high - low) * rng.standard_normal(y_um.size)
    return (y_um + noise_um).astype(np.float32).view(np.uint32)


def _next_displacement(model: Model, y: Words, u: Words) -> Words:
    """y(k+1) of the model from y(k) under u(k): its path along all of u, its terms at rest."""
    if model.responds:
        u_V = np.clip(u.view(np.float32).astype(np.float64), model.u_min_V, model.u_max_V)
        u = applied(model.blocks, u_V, model.Ts_s, model.w_range).astype(np.float32).view(np.uint32)
        model = model.behind_path
    at_rest = Instance(model, y.view(np.float32), np.zeros(y.size, dtype=np.float32))
    return at_rest.predict(y.view(np.float32), u.view(np.float32)).view(np.uint32)


def _random(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Uniform over the range and 15 % of its width beyond either end."""
    low, high = (float(end) for end in limits)
    beyond = 0.15 * (high - low)
    return rng.uniform(low - beyond, high + beyond, n).astype(np.float32).view(np.uint32)


def _smooth(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Signals of a running controller: slow modulated sines with little noise, constant in one block of five."""
    low, high = (float(end) for end in limits)
    k = np.arange(first, first + n, dtype=np.float64)
    phase = 2.0 * np.pi * k / rng.uniform(200.0, 5000.0)
    swing = 0.5 + 0.45 * np.sin(phase) * np.cos(0.01 * phase)
    value = low + (high - low) * (swing + rng.normal(0.0, 1e-4, n))
    value[(k // 3000) % 5 == 4] = value[0]
    return np.asarray(value.astype(np.float32).view(np.uint32))


def _edges(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Zeros, denormals, the range's ends and their neighbours, huge values, infinities and NaN, in runs of 1 to 8."""
    special = _special_values(limits)
    picked = rng.integers(0, special.size, n)
    held = np.maximum.accumulate(np.where(rng.random(n) < 0.7, np.arange(n), 0))
    ordinary = _random(rng, first, n, limits)
    return np.where(rng.random(n) < 0.6, special[picked[held]], ordinary)


def _patterns(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Uniform 32-bit patterns."""
    return rng.integers(0, 1 << 32, n, dtype=np.uint32)


def _special_values(limits: Range) -> Words:
    infinity = np.float32(np.inf)
    tiny = [2.0**-149, 2.0**-127, 2.0**-126, 2.0**-41, 2.0**-40, 2.0**-39]
    numbers = [0.0, *tiny, 1.0, 1e9, 3e38, np.inf, *limits, 0.5 * (float(limits[0]) + float(limits[1]))]
    around = [np.nextafter(end, way) for end in limits for way in (-infinity, infinity)]
    floats = np.array([*numbers, *around], dtype=np.float32)
    # NaN of either sign, quiet and signalling, with full and with empty payloads.
    nans = np.array([0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFBFFFFF, 0x7FFFFFFF], dtype=np.uint32)
    return np.concatenate([floats.view(np.uint32), (-floats).view(np.uint32), nans])


STYLES: Final[Mapping[str, Style]] = {"random": _random, "smooth": _smooth, "edges": _edges, "patterns": _patterns}
SHARES: Final[Mapping[str, float]] = {"random": 0.25, "smooth": 0.4, "edges": 0.2, "patterns": 0.15}
"""Share of the samples per style; the smooth style gets most because it makes the longest meaningful run."""
LEARNING_SHARE: Final = 0.1
"""Samples of `learn` as a share of another function's, off the host: its state has hundreds of words to compare."""
