"""What a commit does to the error of the model in use: python benchmarks/commits.py

Over excitations, plants, noise and settings of the learner: a record of SAMPLES is learnt from, then the shadow is
committed, while the record goes on for its trial. A commit is worse if the bank that is then in use has a larger rms
error in float64 over the samples up to the commit than the bank before. The stages: the model with a tenth less gain,
and the model with 30 % of its voltage behind a play, which its rules cannot show.
"""

from __future__ import annotations

import dataclasses
import itertools
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from hysgen.checking import Host
from hysgen.codegen import Options, generate
from hysgen.float32.coefficients import coefficients
from hysgen.float32.struct_words import Commit
from hysgen.machine.native import Toolchain
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model

Floats = NDArray[np.float64]

SAMPLES: Final = 8192
STEP: Final = 64
TIMES_S: Final = 2e-5 * np.arange(2 * SAMPLES)
EXCITATIONS: Final[Mapping[str, Callable[[Floats], Floats]]] = {
    "sine": lambda t: np.sin(2.0 * np.pi * 130.0 * t),
    "beat": lambda t: np.sin(2.0 * np.pi * 97.0 * t) * np.sin(2.0 * np.pi * 13.0 * t),
    "sines": lambda t: np.sin(2.0 * np.pi * np.outer(t, (31.0, 107.0, 233.0, 419.0))).mean(axis=1),
    "triangle": lambda t: 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * 25.0 * t)),
}
STAGES: Final[Mapping[str, tuple[float, float]]] = {"less gain": (0.9, 0.0), "play": (1.0, 8.0)}
"""Gain over that of the model, and half-width of the play in V."""
NOISE_UM: Final = (0.0, 5e-4, 5e-3)
FORGETTING: Final = (1.0, 0.9999, 0.999, 0.99)


def measured_um(base: Model, u_V: Floats, stage: tuple[float, float], noise_um: float) -> Floats:
    """(n,) displacement of a stage of STAGES."""
    (gain, play_V), through, z = stage, np.empty_like(u_V), u_V[0]
    for k, u in enumerate(u_V):
        through[k] = z = min(max(z, u - play_V), u + play_V)
    plant = dataclasses.replace(base, consequents=base.consequents * [1.0, gain, 1.0])
    y_um = plant.simulate(0.7 * u_V + 0.3 * through)
    return np.asarray(y_um + noise_um * np.random.default_rng(1).standard_normal(y_um.size))


def active(host: Host, instance: Any, model: Model) -> Model:
    """The model with the parameters of the bank in use."""
    bank, strength = instance.bank[instance.active], coefficients(model).fold.astype(np.float64)
    columns = [np.array(list(group)) / strength for group in (bank.slope, bank.gain, bank.offset)]
    return model.with_parameters(np.column_stack(columns).ravel())


def committed(host: Host, model: Model, y_um: Floats, u_V: Floats) -> tuple[Commit, float, float]:
    """Answer of the commit; error of the bank in use then over that before, rms: one step ahead, and in free run."""
    words = [signal.astype(np.float32).view(np.uint32) for signal in (y_um, u_V)]
    instance, learner = host.instance(float(y_um[0]), float(u_V[0])), host.struct(f"{host.name}_learner_t")
    host.call("learn_init", learner, instance)
    before, answer = active(host, instance, model), Commit.BUSY
    for first in (0, *range(SAMPLES, y_um.size, STEP)):
        end = first + STEP if first else SAMPLES
        host.run("learn", learner, [signal[first:end] for signal in words])
        answer = Commit.BUSY
        while answer == Commit.BUSY:
            answer = Commit(host.commit(instance, learner))
        if answer != Commit.TRYING:
            break
    y_um, u_V = y_um[:end], u_V[:end]
    errors = np.empty((2, 2))
    for row, used in enumerate((before, active(host, instance, model))):
        runs = used.predict(y_um, u_V), used.simulate(u_V, y_um[0])
        errors[row] = [np.sqrt(np.mean((run - y_um) ** 2)) for run in runs]
    one_step, free_run = errors[1] / errors[0]
    return answer, float(one_step), float(free_run)


def over(host: Host, model: Model, stage: tuple[float, float]) -> list[tuple[Commit, float, float]]:
    """`committed` of a stage for every excitation and every noise."""
    return [
        committed(host, model, measured_um(model, u_V, stage, noise_um), u_V)
        for shape, noise_um in itertools.product(EXCITATIONS.values(), NOISE_UM)
        for u_V in [50.0 + 60.0 * shape(TIMES_S)]
    ]


def main() -> None:
    """Print one row for each setting of the learner and each stage."""
    from fixtures.generated_models import smooth

    print("forgetting  stage      commits   worse one step ahead  at most  worse in free run  at most")
    for forgetting in FORGETTING:
        model = dataclasses.replace(smooth(6), learner=LearnerSettings(forgetting=forgetting))
        host = Host(model.name, generate(model, Options(clock_Hz=1e10)), Toolchain("cc", ("-O1",)))
        for name, stage in STAGES.items():
            rows = over(host, model, stage)
            made = np.array([ratios for answer, *ratios in rows if answer == Commit.COMMITTED]).reshape(-1, 2)
            (ahead, free), (most_ahead, most_free) = (made > 1.0).sum(axis=0), made.max(axis=0, initial=0.0)
            print(
                f"{forgetting:<10}  {name:<9}  {len(made):2} of {len(rows)}  {ahead:20}  {most_ahead:7.3f}"
                f"  {free:17}  {most_free:7.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
