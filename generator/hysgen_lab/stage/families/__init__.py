"""Test stages of five families of hysteresis, none of them made of play operators or of Duhem states.

    preisach            continuous Preisach density that is no product, integrated on a mesh of the Preisach plane
    relays              Preisach operator of single relays finer than the noise, with random thresholds and weights
    bouc-wen            Bouc-Wen with an exponent of 1 to 2, rising after every turn
    jiles-atherton      Jiles-Atherton with a Langevin curve and a susceptibility that is never negative
    thermal             hysterons that thermal activation switches, the one family that depends on the rate

The rest of a stage is the compiled plant of `hysgen_lab.stage`: exact in continuous time.

A test stage is drawn at random: one family of hysteresis, other effects behind it, and two records of different
commands, with many levels, amplitudes and rates, over the whole range.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import Effect, require
from hysgen_lab.stage.effects.amplifier import NO_HIGH_V, NO_LOW_V, SaturationEffect
from hysgen_lab.stage.effects.mechanics import CreepEffect, ResonanceEffect
from hysgen_lab.stage.effects.readings import DelayEffect, NoiseEffect, PeriodicEffect
from hysgen_lab.stage.families.laws import (
    Family,
    JilesAtherton,
    MeshPreisach,
    RandomRelays,
    RisingBoucWen,
    ThermalHysterons,
    draw,
)
from hysgen_lab.stage.measure import run

Floats = NDArray[np.float64]


def command(rng: np.random.Generator, samples: int, low_V: float, high_V: float, start_V: float) -> Floats:
    """(samples,) in V: from start_V up and down the range in 4 to 8 % of the samples, then sections in random order.

    Sections: steps between held levels, triangles, sines, random walks, reversal curves; each with its own level,
    amplitude and rate, from 40 to 4000 samples a period. Between two sections stands a ramp, or in a third of the cases
    a step.
    """
    sweep = int(rng.uniform(0.04, 0.08) * samples)
    first = np.interp(np.linspace(0, 3, sweep), [0, 1, 2, 3], [start_V, high_V, low_V, rng.uniform(low_V, high_V)])
    parts = [first]
    order: list[Callable[[np.random.Generator, int], Floats]] = []
    while sum(map(len, parts)) < samples:
        order = order or [SECTIONS[i] for i in rng.permutation(len(SECTIONS))]
        wave = order.pop()(rng, int(rng.uniform(0.02, 0.06) * samples))
        # Every fourth section spans the whole range.
        size = 1.0 if len(parts) % 4 == 1 else float(rng.uniform(0.1, 0.9))
        middle = 0.5 + (1 - size) * float(rng.uniform(-0.5, 0.5))
        wave = low_V + (high_V - low_V) * (middle + 0.5 * size * wave)
        if rng.random() < 2 / 3:
            parts.append(np.linspace(parts[-1][-1], wave[0], int(rng.uniform(20, 400))))
        parts.append(wave)
    return np.concatenate(parts)[:samples]


def _period(rng: np.random.Generator, samples: int) -> float:
    return min(float(np.exp(rng.uniform(np.log(40), np.log(4000)))), float(samples))


def _steps(rng: np.random.Generator, samples: int) -> Floats:
    """Levels in -1 .. 1, held for 20 to 500 samples each."""
    holds = rng.integers(20, 500, samples // 20 + 1)
    return np.repeat(rng.uniform(-1, 1, len(holds)), holds)[:samples]


def _triangles(rng: np.random.Generator, samples: int) -> Floats:
    """Triangles whose amplitude changes from one to the next."""
    half = max(2, int(_period(rng, samples) / 2))
    count = samples // half + 2
    corners = rng.uniform(0.2, 1, count) * np.where(np.arange(count) % 2, 1, -1)
    return np.interp(np.arange(samples), half * np.arange(count), corners)


def _sines(rng: np.random.Generator, samples: int) -> Floats:
    """One sine, or the sum of two."""
    k = np.arange(samples)
    share = float(rng.choice([0.0, 0.3]))
    first, second = (np.sin(2 * np.pi * (k / _period(rng, samples) + rng.random())) for _ in range(2))
    return np.asarray((1 - share) * first + share * second)


def _walk(rng: np.random.Generator, samples: int) -> Floats:
    """Straight lines between random levels, each 5 to 300 samples long."""
    ways = np.cumsum(np.exp(rng.uniform(np.log(5), np.log(300), samples // 5 + 2)))
    return np.interp(np.arange(samples), ways - ways[0], rng.uniform(-1, 1, len(ways)))


def _reversals(rng: np.random.Generator, samples: int) -> Floats:
    """Triangles about one level whose amplitude falls to nothing."""
    half = max(2, int(_period(rng, samples) / 8))
    count = samples // half + 2
    corners = np.linspace(1, 0, count) * np.where(np.arange(count) % 2, 1, -1)
    return np.interp(np.arange(samples), half * np.arange(count), corners)


SECTIONS = (_steps, _triangles, _sines, _walk, _reversals)


FAMILIES: Mapping[str, type[Family]] = MappingProxyType(
    {
        "preisach": MeshPreisach,
        "relays": RandomRelays,
        "bouc-wen": RisingBoucWen,
        "jiles-atherton": JilesAtherton,
        "thermal": ThermalHysterons,
    }
)

SCENARIOS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "memory": (),
        "creep": ("creep",),
        "resonance": ("resonance",),
        "delay": ("delay",),
        "saturation": ("saturation",),
        "creep, periodic": ("creep", "periodic"),
    }
)
"""The effects beside hysteresis, lag and noise, by the name of the scenario."""

RATES_HZ = (500.0, 1000.0, 2000.0, 5000.0, 10e3, 20e3, 50e3)
IDENTIFY, SCORE, PAST = 32_000, 16_000, 12_000
"""Rows to identify from, rows to score, and rows of the movement before each record, which no record shows."""


@dataclass(frozen=True, eq=False)
class Plant:
    """A test stage: its family, scenario and seed; range_V: of its commands. stroke_um over this range, slowly."""

    family: str
    scenario: str
    seed: int
    stage: Stage
    Ts_s: float
    range_V: tuple[float, float]
    stroke_um: float

    @property
    def noise_um(self) -> float:
        """Rms of the sensor's white noise."""
        return self.stage.noise.white_um if self.stage.noise is not None else 0.0

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of all effects, hysteresis first; without the noise."""
        return tuple(name for name in self.stage.active if name != NoiseEffect.name)


def plant(family: str, scenario: str, seed: int) -> Plant:
    """The stage of a family, a scenario and a seed: the same arguments give the same stage.

    Raises StageError for an unknown family or scenario.
    """
    require(family in FAMILIES, f"family: {family} is not known; choose one of {', '.join(FAMILIES)}")
    require(scenario in SCENARIOS, f"scenario: {scenario} is not known; choose one of {', '.join(SCENARIOS)}")
    rng = _random(family, scenario, seed, 0)
    Ts_s = 1 / float(rng.choice(RATES_HZ))
    range_V = float(rng.uniform(-18, 10)), float(rng.uniform(70, 118))
    stroke_um = float(np.exp(rng.uniform(np.log(3), np.log(50))))
    noise_um = stroke_um * float(np.exp(rng.uniform(np.log(1e-4), np.log(1 / 3000))))
    lag_s = Ts_s * float(np.exp(rng.uniform(np.log(2), np.log(30))))
    hysteresis = draw(FAMILIES[family], rng, range_V, Ts_s, stroke_um)
    setting = _Setting(Ts_s, range_V, stroke_um, lag_s)
    stage = Stage(
        stroke_um=stroke_um,
        lag_s=lag_s,
        dac_low_V=-60.0,
        dac_high_V=160.0,
        dac_bits=0,
        sensor_step_um=0.0,
        adc_bits=0,
        history_V=(range_V[0], range_V[1], range_V[0]),
        zero_V=range_V[0],
        memory=hysteresis,
        noise=NoiseEffect(noise_um),
        others=tuple(DRAWN[name](rng, setting) for name in SCENARIOS[scenario]),
    )
    return Plant(family, scenario, seed, stage, Ts_s, range_V, stroke_um)


def records(hidden: Plant, rows: tuple[int, int] = (IDENTIFY, SCORE)) -> tuple[tuple[Floats, Floats], ...]:
    """Voltage and reading, (n,) each, of the record to identify from and of the one to score.

    Both begin after PAST rows of another command, of which nothing is known, and cover the same range. A disturbance
    has the same phase at the first row of both, as if the records were triggered by it.
    """
    measured = []
    for number, samples in enumerate(rows, start=1):
        rng = _random(hidden.family, hidden.scenario, hidden.seed, number)
        rest_V = float(rng.uniform(*hidden.range_V))
        past_V = command(rng, PAST, *hidden.range_V, rest_V)
        u_V = command(rng, samples, *hidden.range_V, float(past_V[-1]))
        lines = [_advanced(line, PAST * hidden.Ts_s) for line in hidden.stage.of(PeriodicEffect)]
        stage = hidden.stage.with_effects(periodic=lines)
        noise_seed = int(rng.integers(2**31))
        seen = run(stage, np.concatenate([past_V, u_V]), hidden.Ts_s, noise_seed, rest_V=rest_V)
        measured.append((u_V, seen.displacement_um[PAST:]))
    return tuple(measured)


@dataclass(frozen=True)
class _Setting:
    Ts_s: float
    range_V: tuple[float, float]
    stroke_um: float
    lag_s: float


def _creep(rng: np.random.Generator, setting: _Setting) -> Effect:
    """Creep of 0.5 to 3 % of a step per decade, from 10 to 300 samples on, up to 3 to 300 times the record."""
    begins_s = setting.Ts_s * 10 ** float(rng.uniform(1, 2.5))
    ends_s = IDENTIFY * setting.Ts_s * 10 ** float(rng.uniform(0.5, 2.5))
    return CreepEffect(float(np.exp(rng.uniform(np.log(0.005), np.log(0.03)))), begins_s, ends_s)


def _resonance(rng: np.random.Generator, setting: _Setting) -> Effect:
    """A mode from 50 Hz to a tenth of the sampling rate that carries 10 to 70 % of the motion."""
    f_Hz = float(np.exp(rng.uniform(np.log(50), np.log(max(0.1 / setting.Ts_s, 50)))))
    return ResonanceEffect(f_Hz, float(np.exp(rng.uniform(np.log(0.01), np.log(0.1)))), float(rng.uniform(0.1, 0.7)))


def _delay(rng: np.random.Generator, setting: _Setting) -> Effect:
    return DelayEffect(float(rng.uniform(0.3, 6.7)))


def _saturation(rng: np.random.Generator, setting: _Setting) -> Effect:
    """One level or both, 5 to 20 % of the range inside its ends."""
    low_V, high_V = setting.range_V
    low_cut_V, high_cut_V = rng.uniform(0.05, 0.2, 2) * (high_V - low_V)
    side = int(rng.integers(3))
    lowest_V = low_V + low_cut_V if side != 0 else NO_LOW_V
    highest_V = high_V - high_cut_V if side != 1 else NO_HIGH_V
    return SaturationEffect(lowest_V, highest_V)


def _periodic(rng: np.random.Generator, setting: _Setting) -> Effect:
    """A line of 0.1 to 1 % of the stroke, from 200 periods in the record to a tenth of the sampling rate."""
    slowest_Hz = 200 / (IDENTIFY * setting.Ts_s)
    f_Hz = float(np.exp(rng.uniform(np.log(slowest_Hz), np.log(0.1 / setting.Ts_s))))
    amplitude_um = setting.stroke_um * float(np.exp(rng.uniform(np.log(0.001), np.log(0.01))))
    return PeriodicEffect(f_Hz, amplitude_um, float(rng.uniform(0, 2 * math.pi)))


DRAWN: Mapping[str, Callable[[np.random.Generator, _Setting], Effect]] = MappingProxyType(
    {
        "creep": _creep,
        "resonance": _resonance,
        "delay": _delay,
        "saturation": _saturation,
        "periodic": _periodic,
    }
)


def _advanced(line: PeriodicEffect, later_s: float) -> PeriodicEffect:
    """The line, later_s after which it has the phase that this line has at 0."""
    return PeriodicEffect(line.f_Hz, line.amplitude_um, line.phase_rad - 2 * math.pi * line.f_Hz * later_s)


def _random(family: str, scenario: str, seed: int, purpose: int) -> np.random.Generator:
    require(seed >= 0, f"seed: {seed} is below 0; give a whole number from 0 up")
    return np.random.default_rng([seed, list(FAMILIES).index(family), list(SCENARIOS).index(scenario), purpose])
