"""Scenarios whose hysteresis, creep, sensor and disturbances are other equations than those of the diagnosis.

The hysteresis is one of `hysgen_lab.stage.families`. Beside it, drawn from the seed:

    past         a movement before the record, which the record does not contain
    sensor       white and 1/f noise, a quadratic curve, a jitter of the sampling instant up to 0.1 samples
    converters   12 to 18 bits each
    creep        half of the scenarios by a power law
    resonance    half of them with two modes; a quarter of the modes act on the sensor against the motion
    coupling     half of them by a temperature that the channel shows late
    unknown      stick-slip, jumps, a vibration of changing frequency, or a step of the gain
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.prepare import IDENTIFY
from hysgen.machine.kernels.operators import lag_states
from hysgen.record import Record
from hysgen_lab.stage import CreepEffect, Measurement, NoiseEffect, ResonanceEffect, Stage, run
from hysgen_lab.stage.effects import UNKNOWN, Effect, Setting
from hysgen_lab.stage.effects.amplifier import GainStepEffect
from hysgen_lab.stage.effects.mechanics import StickSlipEffect
from hysgen_lab.stage.effects.memory import Hysteresis, draw_curve
from hysgen_lab.stage.effects.readings import ChirpEffect, JumpsEffect
from hysgen_lab.stage.families import FAMILIES, command
from hysgen_lab.stage.families.laws import ThermalHysterons, draw
from hysgen_lab.studies.bank.scenario import (
    ACCEPTED,
    DRAWN,
    NUMBERS,
    POOR,
    Scenario,
    hidden_causes,
    poor,
    random_levels,
)

Floats = NDArray[np.float64]

RATES_HZ = (500.0, 1000.0, 2000.0, 5000.0, 10e3, 20e3, 50e3)
PAST = 3000
"""Rows of the movement before the record."""

OUTSIDE: tuple[type[Effect], ...] = (StickSlipEffect, JumpsEffect, ChirpEffect, GainStepEffect)
"""Effects outside the vocabulary."""


@dataclass(frozen=True)
class Sensor:
    """Errors of the sensor and of its converter.

    bend: c of the curve y + c s (1 - s) span, s = (y - low) / span. jitter: rms, in samples. bits: of the converter.
    """

    bend: float
    jitter: float
    bits: int

    def reading(self, y_um: Floats, seed: int) -> Floats:
        """(n,) readings of the displacement y_um, (n,)."""
        jitter = self.jitter * np.random.default_rng(seed).standard_normal(len(y_um))
        early_um = y_um + np.clip(jitter, -1.0, 1.0) * np.diff(y_um, prepend=y_um[0])
        low_um, span_um = float(y_um.min()), float(np.ptp(y_um))
        share = (early_um - low_um) / span_um
        bent_um = early_um + self.bend * span_um * share * (1.0 - share)
        # The converter's range is twice the span.
        step_um = 2.0 * span_um / 2.0**self.bits
        return np.asarray(step_um * np.round(bent_um / step_um))


@dataclass(frozen=True, eq=False, kw_only=True)
class FamilyScenario(Scenario):
    """A scenario of a family; the arrays contain PAST rows that the record does not.

    sensor: through which the record is read. logged: channels of the record in place of those in `aux`, which act on
    the stage.
    """

    sensor: Sensor
    logged: Mapping[str, Floats]

    past = PAST

    @property
    def allowed(self) -> tuple[str, ...]:
        """Beside hysterons that thermal activation switches: creep, which they show, and `unknown` for the rest."""
        return ("creep", "relaxation", UNKNOWN) if isinstance(self.stage.memory, ThermalHysterons) else super().allowed

    def record(self, measured: Measurement) -> Record:
        y_um = self.sensor.reading(measured.displacement_um, self.seed)[PAST:]
        shown = {name: values[PAST:] for name, values in self.logged.items()}
        return Record.from_arrays(self.u_V[PAST:], y_um, self.Ts_s, shown, accept=ACCEPTED)

    def measure(self) -> Measurement:
        return run(self.stage, self.u_V, self.Ts_s, self.seed, self.aux)


def family_scenario(family: str, category: str, seed: int) -> FamilyScenario:
    """The scenario of a family, a category and a seed; the same arguments give the same scenario."""
    rng = np.random.default_rng([seed, NUMBERS[category], 1 + list(FAMILIES).index(family)])
    Ts_s = 1.0 / float(rng.choice(RATES_HZ))
    samples = PAST + int(rng.uniform(6000, 9000))
    low_V, high_V = float(rng.uniform(-18.0, 10.0)), float(rng.uniform(70.0, 118.0))
    excitation = "good" if category != "poor" else str(rng.choice(POOR))
    u_V = _command(rng, excitation, samples, low_V, high_V)
    stroke_um = float(np.exp(rng.uniform(np.log(2.0), np.log(80.0))))
    stage = _stage(rng, family, category, stroke_um, (low_V, high_V), Ts_s)
    names = hidden_causes(rng, category)
    aux: dict[str, Floats] = {}
    if rng.random() < 0.3 or "coupling" in names:
        aux["axis2_V"] = random_levels(rng, samples, 0.0, 100.0)
    logged = dict(aux)
    if category == UNKNOWN:
        kind = OUTSIDE[int(rng.integers(len(OUTSIDE)))]
        stage = stage.with_effects(**{kind.name: _identified(kind.draw(rng, Setting(u_V, Ts_s, stroke_um)), u_V, Ts_s)})
    for name in names:
        share = float(np.exp(rng.uniform(np.log(0.002), np.log(0.05))))
        setting = Setting(u_V, Ts_s, stroke_um, share, tuple(aux))
        stage = stage.with_effects(**{DRAWN[name].name: _variant(rng, DRAWN[name].draw(rng, setting), setting)})
        if name == "coupling" and rng.random() < 0.5:
            lag_s = setting.span_s * float(rng.uniform(0.0003, 0.002))
            logged = {name: _lagging(values, lag_s, Ts_s) for name, values in aux.items()}
    bits = int(rng.integers(12, 19))
    sensor = Sensor(float(rng.uniform(-0.02, 0.02)), float(rng.choice([0.0, 0.1]) * rng.random()), bits)
    return FamilyScenario(
        category=category,
        seed=seed,
        stage=stage,
        u_V=u_V,
        Ts_s=Ts_s,
        aux=aux,
        excitation=excitation,
        family=family,
        sensor=sensor,
        logged=logged,
    )


def _command(rng: np.random.Generator, excitation: str, samples: int, low_V: float, high_V: float) -> Floats:
    if excitation == "good":
        past_V = command(rng, PAST, low_V, high_V, float(rng.uniform(low_V, high_V)))
        return np.concatenate([past_V, command(rng, samples - PAST, low_V, high_V, float(past_V[-1]))])
    return poor(excitation, rng, samples, low_V, high_V)


def _stage(
    rng: np.random.Generator, family: str, category: str, stroke_um: float, range_V: tuple[float, float], Ts_s: float
) -> Stage:
    """The stage without effects: stroke_um over the range of the command."""
    low_V, high_V = range_V
    white_um = stroke_um * float(np.exp(rng.uniform(np.log(2e-5), np.log(5e-4))))
    hysteresis: Hysteresis = draw(FAMILIES[family], rng, range_V, Ts_s, stroke_um)
    if category == "none":
        hysteresis = draw_curve(rng, stroke_um * 120.0 / (high_V - low_V))
    return Stage(
        stroke_um=stroke_um,
        lag_s=Ts_s * float(np.exp(rng.uniform(np.log(2.0), np.log(40.0)))),
        dac_low_V=-60.0,
        dac_high_V=160.0,
        dac_bits=int(rng.integers(12, 19)),
        sensor_step_um=0.0,
        adc_bits=0,
        history_V=(low_V, high_V, low_V),
        zero_V=low_V,
        memory=hysteresis,
        noise=NoiseEffect(white_um, white_um * float(rng.uniform(0.0, 0.5))),
    )


def _identified(drawn: Effect, u_V: Floats, Ts_s: float) -> Effect:
    """The drawn effect; a step of the gain in the middle half of the rows that a diagnosis identifies from.

    Before them it is in the past, and behind them no cause is looked for.
    """
    if not isinstance(drawn, GainStepEffect):
        return drawn
    share = drawn.at_s / (Ts_s * len(u_V))
    return dataclasses.replace(drawn, at_s=Ts_s * (PAST + share * IDENTIFY * (len(u_V) - PAST)))


def _variant(rng: np.random.Generator, drawn: Effect, setting: Setting) -> Effect | list[Effect]:
    """The drawn effect by another equation, or several of its kind, where the module's docstring lists one."""
    match drawn:
        case CreepEffect() if rng.random() < 0.5:
            return dataclasses.replace(drawn, exponent=float(rng.uniform(0.1, 0.3)))
        case ResonanceEffect():
            share = drawn.share * float(rng.choice([1.0, 1.0, 1.0, -0.5]))
            first = dataclasses.replace(drawn, share=share)
            if rng.random() < 0.5:
                return first
            second = ResonanceEffect.draw(rng, setting)
            return [first, dataclasses.replace(second, f_Hz=min(first.f_Hz * 2.3, 0.2 / setting.Ts_s), share=0.2)]
    return drawn


def _lagging(values: Floats, lag_s: float, Ts_s: float) -> Floats:
    """(n,) the channel behind a lag of lag_s."""
    return np.asarray(lag_states(values, np.array([-np.expm1(-Ts_s / lag_s)]), values[:1].copy())[:, 0])
