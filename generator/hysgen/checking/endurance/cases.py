"""What a learner has to endure: one period of each drive on the virtual stage, and what corrupts its samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.stage import Stage, run

Floats = NDArray[np.float64]

TS_S: Final = 20e-6
LOW_V: Final = 5.0
HIGH_V: Final = 95.0
SECOND: Final = 50_000
"""Samples of one second."""

SENSOR_NOISE_UM: Final = 0.0005


@dataclass(frozen=True)
class Case:
    """One period of displacements and voltages, (n,) each, and what is done to them in every repetition.

    noise_um, noise_V: rms of the noise that is added. burst_every, burst_length: bursts of NaN and infinities, in
    samples; spike_every: single displacements of +-1e30. 0: none.
    """

    about: str
    y_um: Floats
    u_V: Floats
    noise_um: float = SENSOR_NOISE_UM
    noise_V: float = 0.0
    burst_every: int = 0
    burst_length: int = 0
    spike_every: int = 0


def cases(stage: Stage) -> Mapping[str, Case]:
    """Every case by name, driven over the range LOW_V .. HIGH_V of the good excitation."""
    t_s = TS_S * np.arange(2 * SECOND)
    middle, half = 0.5 * (LOW_V + HIGH_V), 0.5 * (HIGH_V - LOW_V)
    sine = middle + 0.9 * half * np.sin(2.0 * np.pi * 100.0 * t_s)
    triangle = middle + 0.9 * half * (2.0 * np.abs(2.0 * ((0.5 * t_s) % 1.0) - 1.0) - 1.0)
    clipped = np.clip(middle + 8.0 * half * np.sin(2.0 * np.pi * 50.0 * t_s), LOW_V, HIGH_V)
    rest = np.full(2 * SECOND, middle)
    moving = _settled(stage, sine)
    level = float(moving[0].mean())
    return {
        "constant": Case("constant input", *_settled(stage, rest)),
        "noise": Case("pure noise in both signals", np.full(SECOND, level), np.full(SECOND, middle), 0.3, 10.0),
        "sine": Case("single sine, 100 Hz", *moving),
        "triangle": Case("slow triangle, 0.5 Hz", *_settled(stage, triangle)),
        "bursts": Case("sine, bursts of NaN and infinities", *moving, burst_every=1009, burst_length=16),
        "spikes": Case("sine, spikes of 1e30", *moving, spike_every=997),
        "saturation": Case("alternating saturation, 50 Hz", *_settled(stage, clipped)),
    }


def good_drive(seed: int, seconds: float = 1.0) -> Floats:
    """Good excitation: periods of 100 Hz from LOW_V up with amplitudes that change from period to period, in V."""
    rng = np.random.default_rng(seed)
    amplitudes = 0.5 * (HIGH_V - LOW_V) * rng.uniform(0.15, 1.0, 12)
    amplitudes[[0, -1]] = 0.5 * (HIGH_V - LOW_V)
    k = np.arange(round(seconds * SECOND))
    samples = SECOND // 100
    return np.asarray(LOW_V + amplitudes[(k // samples) % 12] * (1.0 - np.cos(2.0 * np.pi * k / samples)))


def measured(stage: Stage, u_V: Floats, seed: int) -> Floats:
    """What the stage's sensor reads under the drive, (n,) in um."""
    return run(stage, u_V, TS_S, seed).displacement_um


def _settled(stage: Stage, u_V: Floats) -> tuple[Floats, Floats]:
    """The last period of two under a periodic drive, noise-free: its end continues in its beginning."""
    displacement = run(stage.quiet(), np.concatenate([u_V, u_V]), TS_S).displacement_um
    return displacement[u_V.size :], u_V
