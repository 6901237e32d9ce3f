"""The paper's experiments on the virtual bench: sections 4.1 and 4.2 and Fig. 11, and open-loop tracking, section 4.3.

The stage is the nominal one: 10 um over 120 V, one pole of 1 ms as in Appendix A, hysteresis, sensor, converters. Its
constants were fixed before the experiments were run and are not tuned to the paper's figures.

The paper scores its own model one step ahead and the Prandtl-Ishlinskii model in free run. Here every model is scored
both ways on the same validation record, beside persistence, y(k+1) = y(k).

Tracking: y_d = 2.0 + 0.6 sin(2 pi f t) um by feed-forward through the inverse, Eq. (11), as generated float32 C,
compiled on the host, with the bits of the DSP. The reference stays at 2.0 um before the sine starts. The first period
is not scored, because the hysteresis still depends on the identification run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.checking import Host
from hysgen.codegen import generate
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.model import Model
from hysgen.model.rivals import fit_proportional, fit_rivals, score_rivals
from hysgen.model.scores import Score, Scores, score, score_prediction
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import Stage, run, signals

Floats = NDArray[np.float64]
Variant = Literal["paper", "refined", "memory"]

TS_S = 20e-6

SENSOR_ZERO_V = 23.0
"""Voltage at which the stage reads 0 um: the zero of Appendix A's static line, 0.66 um at 31 V and 0.083 um/V."""

IDENTIFICATION_SEED, VALIDATION_SEED, TRACKING_SEED = 41, 42, 43


def bench_stage() -> Stage:
    """The nominal stage with the zero of Appendix A."""
    return replace(Stage.nominal(), zero_V=SENSOR_ZERO_V)


def measure(u_V: Floats, seed: int, source: str, before_V: Floats | None = None) -> Record:
    """The record of one run of the bench's stage under u_V, (n,). `before_V` is applied first and not recorded.

    The response of a stage with hysteresis depends on its past input. The experiments of section 4 were run one after
    the other on one stage, so validation and tracking start where the identification ends.
    """
    lead = np.zeros(0) if before_V is None else before_V
    measured = run(bench_stage(), np.concatenate([lead, u_V]), TS_S, seed)
    return Record.from_arrays(u_V, measured.displacement_um[lead.size :], TS_S, source=source)


def identify(record: Record, variant: Variant) -> Model:
    """A model of the record.

    "paper": L = 6, lambda = 1, alpha = 1e6, epsilon = 0, Eq. (10), as in section 4.
    "refined": the same structure with minimised free-run error. "memory": "refined" behind a hysteresis.
    """
    if variant == "paper":
        return fit(record, FitSettings(name="bench", method="rls"))
    if variant == "refined":
        return fit(record, FitSettings(name="bench"))
    return fit(record, FitSettings(name="bench", memory=PathSize()))


SETTLE_S = 0.02
"""Start of a validation record, two periods of 100 Hz, whose error depends on the unknown state of the hysteresis."""


@dataclass(frozen=True)
class PublishedErrors:
    """Errors printed in the paper: e_rms in um (None if not printed) and maximum e_r in percent."""

    e_rms_um: float | None
    e_r_percent: float


@dataclass(frozen=True)
class Experiment:
    """One validation of section 4: input signals of identification and validation in V, and the published errors."""

    name: str
    title: str
    identification: Callable[[], Floats]
    validation: Callable[[], Floats]
    published: PublishedErrors
    published_rival: PublishedErrors | None = None


@dataclass(frozen=True)
class RepeatedExperiment:
    """One experiment repeated: validation record, models and scores by variant.

    started: free-run score from SETTLE_S on, after the first excursion of the input has set the play operators.
    rivals: name and free-run score of each baseline.
    """

    experiment: Experiment
    validation: Record
    models: Mapping[Variant, Model]
    scores: Mapping[Variant, Scores]
    started: Mapping[Variant, Score]
    rivals: tuple[tuple[str, Score], ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        published = self.experiment.published
        return {
            "experiment": self.experiment.name,
            "published": {"e_rms_um": published.e_rms_um, "e_r_percent": published.e_r_percent},
            "variants": {variant: scores.to_json() for variant, scores in self.scores.items()},
            "free_run_after_first_excursion": {variant: part.to_json() for variant, part in self.started.items()},
            "rivals_free_run": {name: rival.to_json() for name, rival in self.rivals},
        }


EXPERIMENTS = (
    Experiment(
        "4.1",
        "Section 4.1: 100 Hz, varying amplitudes",
        lambda: signals.fig5(TS_S, "identification"),
        lambda: signals.fig5(TS_S, "validation"),
        PublishedErrors(0.0016, 0.31),
        PublishedErrors(0.1722, 10.79),
    ),
    Experiment(
        "4.2",
        "Section 4.2: falling frequency and amplitude",
        lambda: signals.fig8(TS_S, "identification"),
        lambda: signals.fig8(TS_S, "validation"),
        PublishedErrors(0.0005, 0.44),
    ),
    Experiment(
        "fig11-sine",
        "Fig. 11 (a, c): 100 Hz sine, model of section 4.2",
        lambda: signals.fig8(TS_S, "identification"),
        lambda: signals.fig11_sine(TS_S),
        PublishedErrors(None, 0.15),
    ),
    Experiment(
        "fig11-non-harmonic",
        "Fig. 11 (b, d): non-harmonic, model of section 4.2",
        lambda: signals.fig8(TS_S, "identification"),
        lambda: signals.fig11_non_harmonic(TS_S),
        PublishedErrors(None, 0.35),
    ),
)


def repeat(experiment: Experiment) -> RepeatedExperiment:
    """Record identification and validation, identify all variants, score them on the validation record."""
    drive_V = experiment.identification()
    known = measure(drive_V, IDENTIFICATION_SEED, f"{experiment.name} identification")
    unseen = measure(experiment.validation(), VALIDATION_SEED, f"{experiment.name} validation", before_V=drive_V)
    variants: tuple[Variant, ...] = ("paper", "refined", "memory")
    models = {variant: identify(known, variant) for variant in variants}
    runs = {variant: [part.y_um for part in free_run(model, unseen)] for variant, model in models.items()}
    return RepeatedExperiment(
        experiment,
        unseen,
        models,
        {variant: score(model, unseen) for variant, model in models.items()},
        {variant: score_prediction(unseen, y_um, round(SETTLE_S / TS_S)) for variant, y_um in runs.items()},
        tuple(score_rivals(fit_rivals(known), unseen)),
    )


REST_S = 0.05
PERIODS = 6


@dataclass(frozen=True)
class PublishedTracking:
    """Errors printed in the paper, with the inverse: e_rms in nm, maximum e_r in percent; proportional: maximum e_r."""

    e_rms_nm: float
    e_r_percent: float
    proportional_percent: float = 18.0


@dataclass(frozen=True)
class Tracking:
    """Tracking at one frequency over the scored samples: reference (n,), reached displacement (n,) by controller."""

    f_Hz: float
    published: PublishedTracking
    t_s: Floats
    reference_um: Floats
    reached_um: Mapping[str, Floats]

    @property
    def e_rms_nm(self) -> dict[str, float]:
        """sqrt(mean (y_d - y)^2) in nm, by controller."""
        return {
            name: 1e3 * float(np.sqrt(np.mean((self.reference_um - y) ** 2))) for name, y in self.reached_um.items()
        }

    @property
    def e_r_percent(self) -> dict[str, float]:
        """max |y_d - y| / max y in percent, by controller."""
        return {
            name: 100.0 * float(np.abs(self.reference_um - y).max() / y.max()) for name, y in self.reached_um.items()
        }

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "f_Hz": self.f_Hz,
            "published": vars(self.published),
            "e_rms_nm": self.e_rms_nm,
            "e_r_percent": self.e_r_percent,
        }


@dataclass(frozen=True)
class TrackingCase:
    """Frequency of the reference, identification signal of the model as in the paper, errors measured in the paper."""

    f_Hz: float
    identification: Callable[[], Floats]
    published: PublishedTracking


CASES = (
    TrackingCase(50.0, lambda: signals.fig8(TS_S, "identification"), PublishedTracking(18.6, 3.14)),
    TrackingCase(100.0, lambda: signals.fig5(TS_S, "identification"), PublishedTracking(15.2, 2.91)),
)


def track_case(case: TrackingCase) -> Tracking:
    """Track one frequency by the proportional law and by the inverses of the paper's, refined and extended models."""
    f_Hz, identification_V = case.f_Hz, case.identification()
    known = measure(identification_V, IDENTIFICATION_SEED, "identification")
    sine_um = signals.tracking_reference(TS_S, f_Hz, PERIODS / f_Hz)
    # One sample more than is scored: the inverse at sample k needs y_d(k+1).
    reference_um = np.concatenate([np.full(round(REST_S / TS_S), sine_um[0]), sine_um])
    drives_V = {"proportional": fit_proportional(known).inverse(reference_um[:-1])}
    variants: dict[Variant, str] = {"paper": "paper's inverse", "refined": "refined inverse", "memory": "with memory"}
    for variant, label in variants.items():
        drives_V[label] = inverse_drive(identify(known, variant), reference_um)
    scored = slice(reference_um.size - sine_um.size + round(1.0 / (f_Hz * TS_S)), reference_um.size - 1)
    reached: dict[str, Floats] = {}
    for name, u_V in drives_V.items():
        tracked = measure(u_V, TRACKING_SEED, "tracking", before_V=identification_V)
        reached[name] = tracked.segments[0].y_um[scored]
    t_s: Floats = TS_S * np.arange(scored.stop - scored.start, dtype=np.float64)
    return Tracking(f_Hz, case.published, t_s, reference_um[scored], reached)


def inverse_drive(model: Model, reference_um: Floats) -> Floats:
    """Voltages (n-1,) of Eq. (11) along a reference (n,), computed by the model's generated C on the host."""
    host = Host(model.name, generate(model))
    bits = reference_um.astype(np.float32).view(np.uint32)
    start_V = 0.5 * (model.u_min_V + model.u_max_V)
    instance = host.instance(float(reference_um[0]), start_V)
    u_bits, _ = host.run("inverse", instance, [bits[:-1], bits[1:]])
    return u_bits.view(np.float32).astype(np.float64)
