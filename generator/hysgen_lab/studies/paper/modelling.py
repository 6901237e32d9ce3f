"""Sections 4.1 and 4.2 and Fig. 11: errors of identified models on a validation record.

The paper scores its own model one step ahead and the Prandtl-Ishlinskii model in free run. Here every model is scored
both ways on the same record, beside persistence, y(k+1) = y(k).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.model.model import Model
from hysgen.model.rivals import fit_rivals, score_rivals
from hysgen.model.scores import Score, Scores, score, score_prediction
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import signals
from hysgen_lab.studies.paper.bench import IDENTIFICATION_SEED, TS_S, VALIDATION_SEED, Variant, identify, measure

Floats = NDArray[np.float64]

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
