"""The learner in generated C on the virtual bench: its accuracy against Eq. (10) in float64, its speed after a change.

The paper learns off line. Here the C for the DSP is compiled on the host; the bench is that of sections 4.1 and 4.2.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.fitting import FitSettings, fit
from hysgen.float32.struct_words import Commit
from hysgen.model.learner_settings import LEARNED, LearnerSettings
from hysgen.model.model import Model
from hysgen.model.scores import score
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.studies.endurance.compiled_learner import CompiledLearner, Excitation, persistent_excitation
from hysgen_lab.studies.paper.experiments import (
    IDENTIFICATION_SEED,
    TS_S,
    VALIDATION_SEED,
    Experiment,
    bench_stage,
    identify,
    measure,
)

Floats = NDArray[np.float64]

# Values of a data sheet, known before any measurement: 10 um over 120 V, one pole of 1 ms.
DATASHEET_UM_PER_V: Final = 10.0 / 120.0
DATASHEET_POLE: Final = float(np.exp(-TS_S / 1e-3))

GAIN_LOST: Final = 0.1
COMMIT_PERIOD_S: Final = 0.01
OBSERVED_S: Final = 2.0
CAUGHT_UP_BELOW: Final = 1.5
"""Free-run error, as a multiple of that before the change, below which the learner has caught up."""

DISTURBANCES: Final[Mapping[str, Callable[[Floats], Floats] | None]] = {
    "gain falls by 10 %": None,
    "and the sensor's sign is wrong": lambda y_um: 2.0 * y_um.mean() - y_um,
    "and the sensor is stuck": lambda y_um: np.full_like(y_um, y_um[0]),
    "and the sensor reads noise only": lambda y_um: np.random.default_rng(5).permutation(y_um),
    "and every second sample is NaN": lambda y_um: np.where(np.arange(y_um.size) % 2, np.nan, y_um),
}
"""Disturbance of the measured displacement after the gain has fallen, by name; None: the measurement is good.

Nothing may be committed from the disturbed ones.
"""


@dataclass(frozen=True)
class LearnerAgreement:
    """One-step e_rms in um on a validation record: of Eq. (10) in float64, and of the learner in generated C."""

    title: str
    float64_um: float
    learned_um: float

    @property
    def excess(self) -> float:
        """Relative excess of the learner's error."""
        return self.learned_um / self.float64_um - 1.0

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"excess": self.excess}


@dataclass(frozen=True)
class GainLoss:
    """The plant's gain falls; `_commit` is called every COMMIT_PERIOD_S.

    before_um, stale_um: free-run rms of the active model on the plant before and just after the change.
    t_s, free_run_um: (n,) time since the change, and free-run rms of the model active at that time.
    committed, refused: numbers of commits by answer, without those on trial. unsafe: committed models whose
    certificates fail in float64.
    """

    what: str
    before_um: float
    stale_um: float
    t_s: Floats
    free_run_um: Floats
    committed: int
    refused: int
    unsafe: int

    @property
    def caught_up_s(self) -> float | None:
        """Time from which the error stays within CAUGHT_UP_BELOW times before_um; None if it never does."""
        late = np.flatnonzero(self.free_run_um > CAUGHT_UP_BELOW * self.before_um)
        first = 0 if late.size == 0 else int(late[-1]) + 1
        return None if first == self.t_s.size else float(self.t_s[first])

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        scalars = {name: getattr(self, name) for name in ("what", "before_um", "stale_um")}
        counts = {name: getattr(self, name) for name in ("committed", "refused", "unsafe", "caught_up_s")}
        return scalars | counts | {"final_um": float(self.free_run_um[-1])}


def agreement(experiment: Experiment) -> LearnerAgreement:
    """Feed an identification record once to the compiled learner, from data-sheet values, with the paper's settings."""
    drive_V = experiment.identification()
    known = measure(drive_V, IDENTIFICATION_SEED, f"{experiment.name} identification")
    unseen = measure(experiment.validation(), VALIDATION_SEED, f"{experiment.name} validation", before_V=drive_V)
    recursive = identify(known, "paper")
    settings = LearnerSettings(learned=LEARNED["rules"], forgetting=1.0, alpha=1e6, rest_V=0.0, window=2**24)
    learner = CompiledLearner(dataclasses.replace(_datasheet(recursive), learner=settings))
    segment = known.segments[0]
    learner.start(float(segment.y_um[0]), float(segment.u_V[0]))
    learner.feed(Excitation("identification", segment.y_um, segment.u_V, noise_um=0.0), segment.y_um.size)
    scores = [score(model, unseen).one_step.e_rms_um for model in (recursive, learner.shadow())]
    return LearnerAgreement(experiment.title, *scores)


def lose_gain(what: str, settings: LearnerSettings | None = None) -> GainLoss:
    """Reduce the plant's gain by GAIN_LOST while the learner runs and commits.

    what: a name in DISTURBANCES. settings: default LearnerSettings().
    """
    disturb = DISTURBANCES[what]
    old, new = bench_stage(), bench_stage().with_effects(aging=(-GAIN_LOST, 1e-3))
    model = fit(_record(old, 3), FitSettings(name="bench", method="batch", margin=0.02, input_range_V=(0.0, 100.0)))
    learner = CompiledLearner(dataclasses.replace(model, learner=settings or LearnerSettings()))
    known, check_old, check_new = _record(old, 1), _record(old, 2), _record(new, 2)
    segment = known.segments[0]
    learner.start(float(segment.y_um[0]), float(segment.u_V[0]))
    before = Excitation("before", segment.y_um, segment.u_V, noise_um=0.0)
    commits, samples = round(OBSERVED_S / COMMIT_PERIOD_S), round(COMMIT_PERIOD_S / TS_S)
    learner.feed(before, segment.y_um.size)
    while learner.commit() == Commit.TRYING:
        learner.feed(before, samples)
    before_um, stale_um = (_free_run_rms_um(learner.active(), check) for check in (check_old, check_new))
    measured_um = _record(new, 1).segments[0].y_um
    after = Excitation("after", measured_um if disturb is None else disturb(measured_um), segment.u_V, noise_um=0.0)
    errors, answers, unsafe = np.empty(commits), [], 0
    for number in range(commits):
        learner.feed(after, samples)
        answers.append(learner.commit())
        active = learner.active()
        if answers[-1] == Commit.COMMITTED:
            held = certify(active)
            unsafe += not (held.contraction_holds and held.inverse_holds)
        errors[number] = _free_run_rms_um(active, check_new)
    committed, trying = (answers.count(answer) for answer in (Commit.COMMITTED, Commit.TRYING))
    t_s = COMMIT_PERIOD_S * np.arange(1.0, commits + 1.0)
    return GainLoss(what, before_um, stale_um, t_s, errors, committed, commits - committed - trying, unsafe)


def _datasheet(like: Model) -> Model:
    """A model with equal rules, y(k+1) = a y + (1 - a) g u, on the grid of `like`."""
    a = DATASHEET_POLE
    rule = [a, (1.0 - a) * DATASHEET_UM_PER_V, 0.0]
    model = like.with_parameters(np.tile(rule, like.grid.rules))
    return dataclasses.replace(model, certificates=certify(model).to_json())


def _record(stage: Stage, seed: int) -> Record:
    u_V = persistent_excitation(seed)
    return Record.from_arrays(u_V, run(stage, u_V, TS_S, seed).displacement_um, TS_S, source=f"drive {seed}")


def _free_run_rms_um(model: Model, record: Record) -> float:
    """Free-run rms over the record without its first 20 ms, in which the gain is still changing."""
    late = round(0.02 / TS_S)
    error = free_run(model, record)[0].y_um[late:] - record.segments[0].y_um[late:]
    return float(np.sqrt(np.mean(error * error)))
