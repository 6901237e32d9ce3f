"""What a named cause means for the user, what to change, and how the stage moves with the cause and without it.

The motion is that under a voltage which shows the cause. The docs show the same motions of the virtual stage.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hysgen.display import decimal
from hysgen.model.model import Model

Floats = NDArray[np.float64]

POINTS = 160
"""Points of a small picture, and samples of a motion that no model simulates."""

FEWEST_SAMPLES, MOST_SAMPLES = 24, 200_000

SHOWN = 0.1
"""Part of the largest difference between both motions from which on a picture shows it."""


@dataclass(frozen=True)
class Seen:
    """What is known of a named cause: its parameters by name, the extended model, stroke of the record and noise."""

    values: Mapping[str, float]
    model: Model
    stroke_um: float
    noise_um: float


@dataclass(frozen=True)
class Advice:
    """means: what the cause does to the user's stage; change: what to do in mechanics, wiring, drive or experiment."""

    means: str
    change: str


@dataclass(frozen=True, eq=False)
class Motion:
    """A voltage as shares of its range, (n,), at Ts_s; words: what the picture shows; loop: drawn over the voltage."""

    levels: Floats
    Ts_s: float
    words: str
    loop: bool = False

    @property
    def time_s(self) -> Floats:
        """(n,) times from 0 on."""
        return self.Ts_s * np.arange(len(self.levels), dtype=np.float64)


def held(seconds: float) -> Motion:
    """The voltage held."""
    return Motion(np.full(POINTS, 0.5), seconds / POINTS, f"{seconds:.3g} s at rest")


def voltage_step(seconds: float, Ts_s: float) -> Motion:
    """A step over half the range, after a tenth of the time."""
    levels = np.full(_samples(seconds, Ts_s), 0.75)
    levels[: len(levels) // 10] = 0.25
    return Motion(levels, Ts_s, f"{decimal(1e3 * Ts_s * len(levels), 3)} ms about a step")


def strokes(seconds: float, Ts_s: float, cycles: int = 1, loop: bool = False) -> Motion:
    """Full strokes in `cycles` periods of a cosine, which end on the sample at which they begin."""
    n = _samples(seconds, Ts_s)
    levels = 0.5 - 0.5 * np.cos(2.0 * np.pi * cycles * np.arange(n) / (n - 1))
    return Motion(levels, Ts_s, f"{'over the voltage, ' if loop else ''}strokes of {Ts_s * n / cycles:.3g} s", loop)


def _samples(seconds: float, Ts_s: float) -> int:
    return int(np.clip(round(seconds / Ts_s), FEWEST_SAMPLES, MOST_SAMPLES))


@dataclass(frozen=True, eq=False)
class Sketch:
    """Two motions over one abscissa, (n,) each, 0 to 1; both lie within -1 .. 2, and 0 to 1 is where they differ.

    words: what is shown; height_um: displacement from 0 to 1.
    """

    x: Floats
    acting: Floats
    free: Floats
    words: str
    height_um: float

    @classmethod
    def of(cls, motion: Motion, acting_um: Floats, free_um: Floats) -> Self:
        """The sketch of both motions, (n,), thinned to POINTS."""
        rows = np.unique(np.linspace(0, len(acting_um) - 1, POINTS).astype(np.intp))
        x = (motion.levels if motion.loop else motion.time_s)[rows]
        free_um = free_um + (acting_um[0] - free_um[0])  # both begin at one place
        apart = np.abs(acting_um - free_um)
        both = np.stack([acting_um, free_um])
        seen = both[:, apart >= SHOWN * apart.max()]
        low_um, height_um = float(seen.min()), max(float(np.ptp(seen)), 1e-12)
        acting, free = np.clip((both[:, rows] - low_um) / height_um, -1.0, 2.0)
        return cls((x - x.min()) / np.ptp(x), acting, free, motion.words, height_um)
