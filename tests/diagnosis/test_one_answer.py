"""One noise floor and one verdict on excitation for one record, whoever is asked: inspect, score, diagnose."""

import numpy as np
import pytest

from hysgen.api.models import fit, score
from hysgen.diagnosis.identifiability import inspect
from hysgen.diagnosis.procedure import name_causes
from hysgen.record import Record
from hysgen_lab.stage import Density, NoiseEffect, Relays, Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.studies.bank.scenario import good

RATE_S, ROWS, NOISE_UM = 1e-3, 3000, 1e-3
T_S = RATE_S * np.arange(ROWS)
LINE, MODE = {"periodic": (50.3, 0.06, 0.0)}, {"resonance": (83.0, 0.02, 0.3)}
COMMANDS_V = {
    "nested": good(np.random.default_rng(5), ROWS, 0.0, 100.0),
    "steps": np.repeat(np.random.default_rng(2).uniform(0.0, 100.0, ROWS // 150), 150),
    "chirp": 50.0 + 45.0 * np.sin(2.0 * np.pi * (2.0 * T_S + 15.0 * T_S**2)),
}


def record_of(u_V: np.ndarray, **effects: tuple[float, ...]) -> Record:
    """Of a stage of random relays, an equation that the analysis does not have."""
    memory = Relays(Density(40.0, 55.0, 15.0, 65.0), 0.15)
    relays = Stage(stroke_um=12.0, lag_s=8e-3, memory=memory, noise=NoiseEffect(NOISE_UM))
    return Record.from_arrays(u_V, measure(relays.with_effects(**effects), u_V, RATE_S, seed=5).displacement_um, RATE_S)


@pytest.mark.parametrize(
    ("command", "effects"),
    [
        pytest.param("nested", {}, id="plain"),
        pytest.param("steps", LINE, id="line"),
        pytest.param("nested", MODE, id="mode", marks=pytest.mark.slow),
        pytest.param("chirp", LINE, id="chirp", marks=pytest.mark.slow),
    ],
)
def test_inspect_score_and_diagnose_say_the_same(command: str, effects: dict[str, tuple[float, ...]]) -> None:
    record = record_of(COMMANDS_V[command], **effects)
    inspected, diagnosed = inspect(record), name_causes(record)
    floors = [inspected.seen.noise, score(fit(record), record).noise, diagnosed.noise]
    assert floors[0] == floors[1] == floors[2]
    # The chirp is fast from its first row on.
    assert floors[0].rms_um == pytest.approx(NOISE_UM, rel=0.35 if command == "chirp" else 0.1)
    # What changes a mode is judged beside one alone.
    excited = {ability.name: ability.excited for ability in inspected.abilities if ability.excited is not None}
    assert (
        excited | {ability.name: ability.excited for ability in diagnosed.abilities if ability.name in excited}
        == excited
    )
