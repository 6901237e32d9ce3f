"""How often the expanded uncertainty of a simulated displacement holds the truth, on virtual stages that state it.

Each stage has a random stroke, lag, hysteresis and noise; its sensor is off by a constant drawn from the uncertainty
that the budget is given. A model is fitted to the first part of the record; at random samples of the rest the error of
its free run against the true displacement is compared with U.

`python -m hysgen_lab.studies.coverage --stages 1000` prints the coverage; the budget states 95 %.
"""

import argparse
import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.noise import noise_floor
from hysgen.uncertainty.gum import SensorUncertainty
from hysgen.uncertainty.simulated import Evidence, budget
from hysgen_lab.stage import Preisach, Stage
from hysgen_lab.stage.effects.memory import Density
from hysgen_lab.stage.effects.readings import NoiseEffect
from hysgen_lab.stage.measure import run

TS_S: Final = 2e-4
ROWS, FITTED = 6000, 4000
DRAWS: Final = 50
"""Held-out samples of each stage that are compared with U."""

SIZE: Final = PathSize(plays=4, degree=2, states=1, hats=2, curve=3)
K: Final = 2.0


@dataclass(frozen=True)
class Coverage:
    """Stages, and the share of held-out samples whose error lies within U. error: its standard error over stages.

    sensor: mean share of the sensor in the variance; it says which contribution the study tried.
    """

    stages: int
    share: float
    error: float
    sensor: float

    def __str__(self) -> str:
        return (
            f"{self.stages} stages: {100 * self.share:.1f} % of the errors within U (+- {100 * self.error:.1f} %); "
            f"the sensor is {100 * self.sensor:.0f} % of the variance on average"
        )


def coverage(stages: int, seed: int = 0) -> Coverage:
    """The coverage over stages with seeds from `seed` on."""
    shares = np.array([one_stage(seed + i) for i in range(stages)])
    error = float(shares[:, 0].std(ddof=1)) / math.sqrt(stages) if stages > 1 else math.nan
    return Coverage(stages, float(shares[:, 0].mean()), error, float(shares[:, 1].mean()))


def one_stage(seed: int) -> tuple[float, float]:
    """(share of DRAWS errors within U, share of the sensor in the variance) of one virtual stage."""
    random = np.random.default_rng(seed)
    stroke_um = float(random.uniform(4.0, 11.0))
    noise_um = float(10.0 ** random.uniform(-3.3, -2.3))
    stage = Stage(
        stroke_um=stroke_um,
        lag_s=float(random.uniform(0.5e-3, 3e-3)),
        memory=Preisach(Density(float(random.uniform(25, 60)), float(random.uniform(45, 75)), 20.0, 65.0)),
        noise=NoiseEffect(noise_um),
    )
    u_V = drive(random)
    measured = run(stage, u_V, TS_S, seed)
    sensor = SensorUncertainty(K * float(10.0 ** random.uniform(-2.5, -0.7)), K, "drawn")
    offset_um = sensor.standard_um * float(random.standard_normal())
    reading = Record.from_arrays(u_V, measured.displacement_um + offset_um, TS_S)
    fitted = reading.rows(0, FITTED)
    model = fit(fitted, FitSettings(method="batch", rules=3, memory=SIZE))
    simulated = free_run(model, reading)[0].y_um[FITTED:]
    evidence = Evidence(
        residual_um=simulated - reading.segments[0].y_um[FITTED:],
        noise=noise_floor(reading),
        fitted=FITTED,
        parameters=model.consequents.size,
        sensor=sensor,
    )
    stated = budget(evidence)
    chosen = random.choice(ROWS - FITTED, DRAWS, replace=False)
    errors = np.abs(simulated - measured.truth.true_um[FITTED:])[chosen]
    return float(np.mean(errors <= stated.expanded_um)), sensor.standard_um**2 / stated.combined_um**2


def drive(random: np.random.Generator) -> NDArray[np.float64]:
    """(ROWS,) two sines whose amplitudes change, over 0 .. 100 V, in V."""
    t = TS_S * np.arange(ROWS)
    slow, fast = random.uniform(1.0, 4.0), random.uniform(8.0, 25.0)
    envelope = 0.6 + 0.4 * np.cos(2 * np.pi * t * random.uniform(0.5, 1.5) + random.uniform(0.0, 6.28))
    wave = 0.7 * envelope * np.sin(2 * np.pi * slow * t) + 0.3 * np.sin(2 * np.pi * fast * t)
    voltage: NDArray[np.float64] = 50.0 + 50.0 * wave
    return voltage


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stages", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    print(coverage(chosen.stages, chosen.seed))
