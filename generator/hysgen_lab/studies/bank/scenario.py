"""A scenario of the bank: a stage with hidden effects, its command, and the causes that a diagnosis should name.

Strengths, rates, ranges, noise and hysteresis are drawn from the seed. No value comes from the analysis. Commands: a
good excitation, which every cause responds to, and poor ones.

The error of the extended model with the truth known is a bound for the error after a diagnosis: the shape parameters of
the extensions are those of the plant, and the plant is run without the effects that extensions only take out of a
record. The fit finds the linear parameters.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.causes.creep import PER_DECADE, CreepPart
from hysgen.diagnosis.evaluation import Extension, free_run_error, prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import PathSize
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.part import Mode
from hysgen.model.path import InputBlock
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes
from hysgen.record import Record
from hysgen_lab.stage import Measurement, NoiseEffect, Stage, effects, run
from hysgen_lab.stage.effects import UNKNOWN, Effect, Setting
from hysgen_lab.stage.effects.memory import Curve, Hysteresis, draw_curve, draw_hysteresis

Floats = NDArray[np.float64]
POOR = ("one sine", "small strokes", "slow triangle")


def good(rng: np.random.Generator, samples: int, low_V: float, high_V: float) -> Floats:
    """Sines of several amplitudes, levels and frequencies over a decade, joined by ramps and steps, with plateaus.

    (samples,) in V; the first stroke runs through the whole range.
    """
    middle, half = 0.5 * (low_V + high_V), 0.5 * (high_V - low_V)
    slowest = samples / 12.0
    parts: list[Floats] = []
    while sum(map(len, parts)) < samples:
        size = 1.0 if len(parts) % 6 == 0 else float(rng.uniform(0.2, 1.0))
        period = int(slowest / 10.0 ** rng.uniform(-0.2, 0.9))
        centre = middle + rng.uniform(-1.0, 1.0) * (1.0 - size) * half
        length = int(period * rng.choice([1.0, 1.5, 2.0]))
        wave = centre + size * half * np.sin(2 * np.pi * np.arange(length) / period - np.pi / 2)
        if parts:
            parts.append(_transition(rng, float(parts[-1][-1]), float(wave[0]), period))
        parts.append(wave)
        if rng.random() < 0.4:
            parts.append(np.full(int(rng.uniform(0.01, 0.04) * samples), wave[-1]))
    return np.concatenate(parts)[:samples]


def poor(kind: str, rng: np.random.Generator, samples: int, low_V: float, high_V: float) -> Floats:
    """An excitation of one of the kinds POOR, (samples,) in V."""
    middle, half = 0.5 * (low_V + high_V), 0.5 * (high_V - low_V)
    turns = np.arange(samples) / samples
    if kind == "one sine":
        return np.asarray(middle + half * np.sin(2 * np.pi * rng.uniform(15, 40) * turns))
    if kind == "small strokes":
        return np.asarray(middle + 0.03 * half * np.sin(2 * np.pi * rng.uniform(20, 60) * turns))
    strokes = turns * rng.uniform(1.5, 3.0)
    return np.asarray(low_V + 2 * half * (1.0 - np.abs(1.0 - 2.0 * (strokes % 1.0))))


def random_levels(rng: np.random.Generator, samples: int, low: float, high: float) -> Floats:
    """A further channel, (samples,): straight lines between 40 to 80 random levels."""
    corners = np.linspace(0, samples - 1, int(rng.uniform(40, 80)))
    return np.interp(np.arange(samples), corners, rng.uniform(low, high, len(corners)))


def _transition(rng: np.random.Generator, begin_V: float, end_V: float, period: int) -> Floats:
    if rng.random() < 0.4:
        return np.full(max(2, period // 6), end_V)  # a step, and time to ring
    length = max(2, period // 4)
    return begin_V + (end_V - begin_V) * (1.0 - np.cos(np.pi * np.arange(length) / length)) / 2.0


ACCEPTED = ("constant", "saturation")
"""Findings for which a record is refused, accepted here: a drawn stage may rest, or ring beyond its converter."""

DRAWN: Mapping[str, type[Effect]] = {
    kind.cause(): kind
    for kind in sorted((k for k in effects().values() if k.bank_index is not None), key=lambda k: k.bank_index or 0)
}
"""Effects that the bank draws, by the cause to be named, in the order of their numbers."""

EFFECTS = tuple(name for name in DRAWN if name != UNKNOWN)
NUMBERS = {name: kind.bank_index or 0 for name, kind in DRAWN.items()} | {
    "pair": 10,
    Hysteresis.name: 11,
    "none": 12,
    "poor": 14,
}
"""Number of each category; it seeds the category's scenarios and never changes."""

CATEGORIES = tuple(sorted(NUMBERS, key=lambda name: NUMBERS[name]))
OWN = ""
"""In place of a family's name: the bank's own stage, whose parts are those of the diagnosis' chain."""

RATES_HZ = (200.0, 1000.0, 5000.0, 10e3, 50e3)


@dataclass(frozen=True, eq=False)
class Scenario:
    """A stage, its command u_V, (n,), and further channels, each (n,); category: one of CATEGORIES.

    family: of hysteresis, "" for those of the bank's own stage. past: first rows of the arrays that the record lacks.
    """

    category: str
    seed: int
    stage: Stage
    u_V: Floats
    Ts_s: float
    aux: Mapping[str, Floats]
    excitation: str
    family: str = OWN

    past: ClassVar[int] = 0

    def measure(self) -> Measurement:
        """The measurement of the stage over all rows."""
        return run(self.stage, self.u_V, self.Ts_s, self.seed, self.aux)

    def record(self, measured: Measurement) -> Record:
        """The record of a measurement of this stage, or of one without some of its effects."""
        return Record.from_arrays(self.u_V, measured.displacement_um, self.Ts_s, self.aux, accept=ACCEPTED)

    @property
    def allowed(self) -> tuple[str, ...]:
        """Causes that may be named although no effect plants them."""
        return ("curve",) if isinstance(self.stage.memory, Curve) else ()

    @property
    def planted(self) -> tuple[str, ...]:
        """The causes that a diagnosis should name: those of the stage's active effects."""
        return tuple(effects()[name].cause() for name in self.stage.active)


def hidden_causes(rng: np.random.Generator, category: str) -> tuple[str, ...]:
    """The causes of the vocabulary, beside memory, whose effects a scenario of the category draws."""
    if category in EFFECTS:
        return (category,)
    if category == "pair":
        return tuple(str(name) for name in rng.choice(EFFECTS, 2, replace=False))
    return (str(rng.choice(EFFECTS)),) if category == "poor" else ()


def scenario(category: str, seed: int) -> Scenario:
    """The scenario of a category and a seed; the same arguments give the same scenario."""
    rng = np.random.default_rng([seed, NUMBERS[category]])
    Ts_s = 1.0 / float(rng.choice(RATES_HZ))
    samples = int(rng.uniform(6000, 9000))
    low_V, high_V = float(rng.uniform(-18.0, 10.0)), float(rng.uniform(70.0, 118.0))
    excitation = "good" if category != "poor" else str(rng.choice(POOR))
    u_V = good(rng, samples, low_V, high_V) if excitation == "good" else poor(excitation, rng, samples, low_V, high_V)
    stroke_um = float(np.exp(rng.uniform(np.log(2.0), np.log(80.0))))
    span_um = stroke_um * (high_V - low_V) / 120.0
    # A converter resolves 16 bits of its range, whatever the stage; noise is 2e-5 to 5e-4 of the stroke.
    stage = Stage(
        stroke_um=stroke_um,
        lag_s=Ts_s * float(np.exp(rng.uniform(np.log(2.0), np.log(40.0)))),
        sensor_step_um=0.0,
        adc_low_um=-0.8 * stroke_um,
        adc_high_um=2.0 * stroke_um,
        memory=_hysteresis(rng, category, stroke_um),
        noise=NoiseEffect(stroke_um * float(np.exp(rng.uniform(np.log(2e-5), np.log(5e-4))))),
    )
    names = hidden_causes(rng, category)
    if category == UNKNOWN:
        stage = _planted(stage, DRAWN[category], rng, Setting(u_V, Ts_s, span_um))
    kinds = [DRAWN[name] for name in names]
    aux: dict[str, Floats] = {}
    if rng.random() < 0.3 or any(kind.needs_channel for kind in kinds):
        aux["axis2_V"] = random_levels(rng, samples, 0.0, 100.0)
    for kind in kinds:
        share = float(np.exp(rng.uniform(np.log(0.002), np.log(0.05))))
        stage = _planted(stage, kind, rng, Setting(u_V, Ts_s, span_um, share, tuple(aux)))
    return Scenario(category, seed, stage, u_V, Ts_s, aux, excitation)


def _planted(stage: Stage, kind: type[Effect], rng: np.random.Generator, setting: Setting) -> Stage:
    return stage.with_effects(**{kind.name: kind.draw(rng, setting)})


def memory_only(hidden: Scenario) -> Scenario:
    """The same stage, driven the same way, with no effect but its hysteresis."""
    return dataclasses.replace(hidden, category=Hysteresis.name, stage=dataclasses.replace(hidden.stage, others=()))


def _hysteresis(rng: np.random.Generator, category: str, stroke_um: float) -> Hysteresis:
    kind = rng.random()
    return draw_curve(rng, stroke_um) if category == "none" else draw_hysteresis(rng, stroke_um, kind)


def error_with_truth_known(hidden: Scenario) -> float:
    """Free-run rms in um on the held-out rows of the model with every planted cause extended by the plant's numbers."""
    treated = [name for name, extension in _extensions(hidden).items() if extension is None]
    clean = dataclasses.replace(hidden, stage=hidden.stage.with_effects(**dict.fromkeys(treated)))
    prepared = prepare(clean.record(clean.measure()))
    extensions = true_extensions(hidden)
    return rms(free_run_error(prepared, extensions, list(extensions))[prepared.held_rows])


def true_extensions(hidden: Scenario) -> dict[str, Extension]:
    """The extension of every planted cause that acts on the model, with the parameters of the plant."""
    return {name: extension for name, extension in _extensions(hidden).items() if extension is not None}


def _extensions(hidden: Scenario) -> dict[str, Extension | None]:
    """The extension of every planted cause; None where the diagnosis treats the record instead of the model."""
    parameters: dict[str, float] = {}
    for effect in hidden.stage.effects:
        parameters |= effect.true_parameters()
    channels = {name: np.asarray(hidden.aux[name]) for name in hidden.stage.channels}
    ranges = {name: (float(values.min()), float(values.max())) for name, values in channels.items()}
    span_s, lag_s = hidden.Ts_s * len(hidden.u_V), hidden.stage.lag_s
    return {
        name: true_extension(name, parameters, ranges, span_s, lag_s) for name in causes() if name in hidden.planted
    }


def true_extension(
    cause: str, parameters: Mapping[str, float], ranges: Mapping[str, tuple[float, float]], span_s: float, lag_s: float
) -> Extension | None:
    """The extension with the true parameters of a plant, by "cause.parameter"; None if it changes the record alone.

    ranges: of the channels that act. span_s: length of the record. lag_s: of the stage.
    """

    def own(*names: str) -> list[float]:
        return [parameters[f"{cause}.{name}"] for name in names]

    made: dict[str, Callable[[], InputBlock | Term]] = {
        "coupling": lambda: Coupling.of(ranges),
        "periodic": lambda: Periodic(tuple(own("f_Hz"))),
        "resonance": lambda: Modes.of([Mode(*own("f_Hz", "zeta", "share"))], lag_s),
        "creep": lambda: CreepPart(own("per_decade")[0], own("from_s")[0]).slow_states(span_s, PER_DECADE),
        "delay": lambda: Delay(*own("delay_samples")),
        "slew": lambda: Slew(*own("rate_V_per_s", "rate_V_per_s")),
        "saturation": lambda: Saturation(*own("low_V", "high_V")),
    }
    if cause not in made:
        return Extension(size=PathSize(), lag_s=lag_s) if cause == "memory" else None
    part = made[cause]()
    return Extension(term=part) if isinstance(part, Term) else Extension(block=part, lag_s=lag_s)
