"""Measuring a virtual stage: the record that a controller would log, and the signals that it does not show."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import require
from hysgen_lab.stage.effects.memory import Curve, Hysteresis
from hysgen_lab.stage.state import PlantOutput, StageState, static_path

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """The signals and settings behind a measurement, each array (n,).

    true_um: displacement without sensor noise, outliers and quantisation. actuator_V: voltage across the ceramic.
    drift_um: movement independent of the input. outlier: whether a reading is corrupted.
    """

    stage: Stage
    seed: int
    true_um: Floats
    actuator_V: Floats
    drift_um: Floats
    outlier: NDArray[np.bool_]


@dataclass(frozen=True)
class Measurement:
    """A record as measured: row k holds y(k), read just before u(k) is put out. Each array (n,)."""

    time_s: Floats
    voltage_V: Floats
    displacement_um: Floats
    aux: Mapping[str, Floats]
    truth: Truth


def run(
    stage: Stage,
    u_V: Floats,
    Ts_s: float,
    seed: int = 0,
    aux: Mapping[str, Floats] | None = None,
    rest_V: float | None = None,
) -> Measurement:
    """Drive the stage with u_V (n,) at sampling period Ts_s and log what its A/D reads.

    The stage starts in equilibrium at rest_V (default u_V[0]). aux: further logged channels (n,) by name; those of
    `stage.channels` act on it. The same arguments give the same bytes.
    Raises StageError for an empty or non-finite input, a channel that is missing, or one of another length.
    """
    command_V = np.array(u_V, dtype=np.float64)
    channels = {name: np.array(values, dtype=np.float64) for name, values in (aux or {}).items()}
    require(command_V.ndim == 1 and len(command_V) > 0, "u_V: one row of voltages is needed; give an array (n,)")
    require(bool(np.isfinite(command_V).all()), "u_V: holds values that are not finite; drive with real voltages")
    for name, values in channels.items():
        require(values.shape == command_V.shape, f"aux {name}: {values.shape} values for {len(command_V)} samples")
        require(bool(np.isfinite(values).all()), f"aux {name}: holds values that are not finite; give real ones")
    start_V = float(command_V[0]) if rest_V is None else rest_V
    trace = _drive(stage, command_V, Ts_s, seed, channels, start_V)
    truth = Truth(stage, seed, trace.true_um, trace.actuator_V, trace.drift_um, trace.outlier)
    return Measurement(np.arange(len(command_V), dtype=np.float64) * Ts_s, command_V, trace.reading_um, channels, truth)


def effect_shares(measurement: Measurement, rows: NDArray[np.intp] | None = None) -> dict[str, float]:
    """Rms in um of the change of the noise-free readings without each active effect, less the change's mean.

    A constant change belongs to the sensor's zero and is no error. The stage starts at rest at the first voltage; at
    least two samples are needed. rows: those that count, all by default.
    """
    stage = measurement.truth.stage
    quiet = stage.quiet()
    Ts_s = float(measurement.time_s[1])
    u_V, seed, aux = measurement.voltage_V, measurement.truth.seed, measurement.aux
    rest_V = float(u_V[0])
    whole = _drive(quiet, u_V, Ts_s, seed, aux, rest_V)
    low_V, high_V = float(whole.actuator_V.min()), float(whole.actuator_V.max())
    counted = slice(None) if rows is None else rows
    rms: dict[str, float] = {}
    for effect in stage.active:
        if effect == Hysteresis.name and not low_V < high_V:
            continue
        part = _drive(without(quiet, effect, low_V, high_V), u_V, Ts_s, seed, aux, rest_V)
        rms[effect] = float(np.std((whole.reading_um - part.reading_um)[counted]))
    return rms


def static_loop(stage: Stage, low_V: float, high_V: float, points: int = 401) -> tuple[Floats, Floats, Floats]:
    """The closed loop of the hysteresis between two voltages: voltages, w rising, w falling, each (points,)."""
    u_V = np.linspace(low_V, high_V, points)
    # Bouc-Wen loops close only after some turns.
    settle = np.tile([low_V, high_V], 8)
    w_um = static_path(stage, np.concatenate([settle, u_V, u_V[::-1]]))[len(settle) :]
    return u_V, w_um[:points], w_um[points:][::-1]


def without(stage: Stage, effect: str, low_V: float, high_V: float) -> Stage:
    """The stage without one effect. Memory is replaced by the mean curve of the loop over low_V .. high_V."""
    if effect != Hysteresis.name:
        return stage.with_effects(**{effect: None})
    u_V, rising_um, falling_um = static_loop(stage, low_V, high_V)
    return replace(stage, memory=Curve(low_V, float(u_V[1] - u_V[0]), tuple(((rising_um + falling_um) / 2).tolist())))


def _drive(
    stage: Stage, u_V: Floats, Ts_s: float, seed: int, channels: Mapping[str, Floats], rest_V: float
) -> PlantOutput:
    names = stage.channels
    missing = [name for name in names if name not in channels]
    require(not missing, f"aux: the stage couples to {', '.join(missing)}, which is not given; pass it in aux")
    others = np.stack([channels[name] for name in names], axis=1) if names else np.zeros((len(u_V), 0))
    return StageState(stage, Ts_s, seed, rest_V, tuple(others[0])).advance(u_V, others)
