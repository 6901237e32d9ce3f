"""Excitations of the endurance test: one period of each signal on the virtual stage, and the corruption of samples."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage import Stage, run

Floats = NDArray[np.float64]

TS_S: Final = 20e-6
LOW_V: Final = 5.0
HIGH_V: Final = 95.0
SECOND: Final = 50_000
"""Samples of one second."""

SENSOR_NOISE_UM: Final = 0.0005


@dataclass(frozen=True)
class Excitation:
    """One period of displacement and voltage, (n,) each, and the corruption of every repetition.

    noise_um, noise_V: rms of the added noise. burst_every, burst_length: bursts of NaN and infinities, in samples.
    spike_every: single displacements of +-1e30, in samples. 0 turns a corruption off.
    """

    about: str
    y_um: Floats
    u_V: Floats
    noise_um: float = SENSOR_NOISE_UM
    noise_V: float = 0.0
    burst_every: int = 0
    burst_length: int = 0
    spike_every: int = 0


def excitations(stage: Stage) -> Mapping[str, Excitation]:
    """Every excitation by its name in CASES, between LOW_V and HIGH_V."""
    t_s = TS_S * np.arange(2 * SECOND)
    middle, half = 0.5 * (LOW_V + HIGH_V), 0.5 * (HIGH_V - LOW_V)
    sine = middle + 0.9 * half * np.sin(2.0 * np.pi * 100.0 * t_s)
    triangle = middle + 0.9 * half * (2.0 * np.abs(2.0 * ((0.5 * t_s) % 1.0) - 1.0) - 1.0)
    clipped = np.clip(middle + 8.0 * half * np.sin(2.0 * np.pi * 50.0 * t_s), LOW_V, HIGH_V)
    rest = np.full(2 * SECOND, middle)
    moving = _periodic_response(stage, sine)
    level = float(moving[0].mean())
    return {
        "constant": Excitation("constant input", *_periodic_response(stage, rest)),
        "noise": Excitation("pure noise in both signals", np.full(SECOND, level), np.full(SECOND, middle), 0.3, 10.0),
        "sine": Excitation("single sine, 100 Hz", *moving),
        "triangle": Excitation("slow triangle, 0.5 Hz", *_periodic_response(stage, triangle)),
        "bursts": Excitation("sine, bursts of NaN and infinities", *moving, burst_every=1009, burst_length=16),
        "spikes": Excitation("sine, spikes of 1e30", *moving, spike_every=997),
        "saturation": Excitation("alternating saturation, 50 Hz", *_periodic_response(stage, clipped)),
    }


def persistent_excitation(seed: int, seconds: float = 1.0) -> Floats:
    """Persistent excitation in V: periods of 100 Hz from LOW_V upwards, each with another random amplitude."""
    rng = np.random.default_rng(seed)
    amplitudes = 0.5 * (HIGH_V - LOW_V) * rng.uniform(0.15, 1.0, 12)
    amplitudes[[0, -1]] = 0.5 * (HIGH_V - LOW_V)
    k = np.arange(round(seconds * SECOND))
    samples = SECOND // 100
    return np.asarray(LOW_V + amplitudes[(k // samples) % 12] * (1.0 - np.cos(2.0 * np.pi * k / samples)))


def measured(stage: Stage, u_V: Floats, seed: int) -> Floats:
    """The sensor's readings under the input u_V, (n,) in um."""
    return run(stage, u_V, TS_S, seed).displacement_um


def _periodic_response(stage: Stage, u_V: Floats) -> tuple[Floats, Floats]:
    """The second of two noise-free periods and its input, (n,) each, so that repetitions join without a jump."""
    displacement = run(stage.quiet(), np.concatenate([u_V, u_V]), TS_S).displacement_um
    return displacement[u_V.size :], u_V
