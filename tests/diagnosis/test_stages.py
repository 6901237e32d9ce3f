"""Whole diagnoses: of stages made by hand, of a cut record, and of fifty foreign stages.

The foreign stages share no equation with the model, the probe, or the virtual stage.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import StateSpace, cont2discrete, lfilter, lsim

import hysgen
from fixtures import soft_springs
from fixtures.foreign_stages import EFFECTS, FAMILIES, foreign_record, repeating_record
from hysgen.api.diagnosing import scored_extension
from hysgen.codegen import generate
from hysgen.diagnosis import DiagnoseSettings, diagnose
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.procedure import name_causes
from hysgen.errors import ModelError
from hysgen.model.path.loop import Loop
from hysgen.record import Record, Segment, load_record
from hysgen.record.read import bundled_csv
from hysgen.report.words import price_of, verdict
from hysgen_lab.stage import ResonanceEffect, Stage, run
from hysgen_lab.stage.effects.mechanics import SofteningEffect
from hysgen_lab.studies.bank.scenario import good

STEP_S, HELD, FINE = 2.5e-4, 1000, 20
LEVELS_V = (0.0, 55.0, 95.0, 15.0, 75.0, 5.0, 65.0, 35.0)
MODE_HZ, DAMPING = 380.0, 0.025


def stepped(early: int) -> Record:
    """Backlash of three widths, creep by 1.5 % in each of three decades, a mode, read early / FINE samples early."""
    levels, play = np.array(LEVELS_V), np.zeros((3, len(LEVELS_V)))
    for k in range(1, len(levels)):
        play[:, k] = np.clip(play[:, k - 1], levels[k] - (5.0, 12.0, 20.0), levels[k] + np.array((5.0, 12.0, 20.0)))
    still_um = np.repeat(0.06 * levels + np.array((0.01, 0.01, 0.02)) @ play, HELD * FINE)
    fine_s, crept_um = STEP_S / FINE, still_um.copy()
    for tau_s in (0.008, 0.08, 0.8):
        slow = StateSpace([[-1.0 / tau_s]], [[1.0 / tau_s]], [[1.0]], [[0.0]])
        crept_um += 0.015 * lsim(slow, still_um, fine_s * np.arange(still_um.size), interp=False)[1]
    w = 2.0 * np.pi * MODE_HZ
    mode = StateSpace([[0.0, 1.0], [-w * w, -2.0 * DAMPING * w]], [[0.0], [w * w]], [[1.0, 0.0]], [[0.0]])
    rung_um = lsim(mode, crept_um, fine_s * np.arange(crept_um.size), interp=False)[1]
    read_um = np.append(rung_um[early:], np.full(early, rung_um[-1]))[::FINE]
    noise_um = 1e-3 * np.random.default_rng(len(LEVELS_V)).normal(size=read_um.size)
    return Record.from_arrays(np.repeat(levels, HELD), read_um + noise_um, STEP_S)


@pytest.mark.slow
def test_a_few_levels_show_the_mode_and_creep_and_memory_stays() -> None:
    """Each level is passed once: nothing shows that the gain changes, and that a curve bends there fits as well."""
    names = name_causes(stepped(4))
    assert sorted(names.names) == ["creep", "memory", "resonance"], names.names
    assert "resonance.f_2_Hz" not in names.estimates
    assert names.estimates["resonance.f_Hz"].value == pytest.approx(MODE_HZ, rel=1e-3)


TS_S = 1.0 / 6400.0
F_HZ, ZETA = (641.0, 814.0, 1325.0, 2133.0), (0.010, 0.012, 0.008, 0.011)
SHAPES = ((0.6, -0.8), (-0.7, 0.9), (0.6, 0.6), (0.2, -0.5))


def segment(seed: int, samples: int) -> Segment:
    """Displacement of four modes under two held noises, and 0.01 um of noise."""
    rng = np.random.default_rng(seed)
    v = np.repeat(rng.uniform(-1.0, 1.0, (2, samples // 3 + 1)), 3, axis=1)[:, :samples]
    y = 0.01 * rng.standard_normal(samples)
    for f_Hz, zeta, shapes in zip(F_HZ, ZETA, SHAPES, strict=True):
        w = 2.0 * np.pi * f_Hz
        b, a, _ = cont2discrete(([w * w], [1.0, 2.0 * zeta * w, w * w]), TS_S)
        for drive, shape in zip(v, shapes, strict=True):
            y += shape * lfilter(np.ravel(b), a, drive)
    return Segment(str(seed), v[0], y, {"other_V": v[1]})


@pytest.mark.slow
def test_modes_of_two_drives_are_named_and_delivered() -> None:
    known, fresh = (Record.from_segments([segment(seed, n)], TS_S) for seed, n in ((1, 9000), (2, 4000)))
    found = diagnose(known, fresh)
    assert found.names == ("resonance",)
    [named] = found.causes
    frequencies = sorted(e.value for key, e in named.parameters.items() if key.startswith("f"))
    assert frequencies == pytest.approx(list(F_HZ), rel=1e-3)
    assert [block.kind for block in found.model.blocks] == ["hysteresis", "structure"]
    assert [term.kind for term in found.model.terms] == ["drives"]
    # 0.01 um of noise, and as much of what 9000 rows leave open.
    assert found.extended_rms_um < 0.02 < 0.02 * found.base_rms_um
    assert any(name.endswith(".c") for name in generate(found.model))


@pytest.mark.slow
def test_modes_of_two_drives_that_soften_are_named_and_delivered() -> None:
    """Springs that yield, which no model of hysgen has; the same stage with straight springs only rings."""
    for yields_um, names in ((40.0, ("resonance", "softening")), (np.inf, ("resonance",))):
        known = soft_springs.record((0.5, 1.0, 2.0), 3000, 1, yields_um)
        found = diagnose(known, soft_springs.record((1.0,), 3000, 2, yields_um))
        assert tuple(name for name in found.names if name != "unknown") == names
        if len(names) > 1:
            values = {key: value.value for key, value in found.causes[1].parameters.items()}
            assert min(abs(values["small_f_Hz"] / f_Hz - 1.0) for f_Hz in soft_springs.F_HZ) < 5e-3
            assert values["f_Hz"] < values["small_f_Hz"]
            assert [block.kind for block in found.model.blocks][-1] == "softening"
            assert found.model.terms == ()
            # 1.0 um where the modes stand still.
            assert found.extended_rms_um < 0.5
            assert any(name.endswith(".c") for name in generate(found.model))


SOFT_TS_S, SOFT_HZ = 1e-4, 300.0


def record(stage: Stage, seed: int, samples: int) -> Record:
    """Lines about the mode, at a level that changes every 500 samples."""
    rng = np.random.default_rng(seed)
    lines_Hz = np.arange(20.0, 2.2 * SOFT_HZ, 6.0) + rng.uniform(-2.0, 2.0, 107)
    phases = 2.0 * np.pi * (lines_Hz[:, None] * SOFT_TS_S * np.arange(samples) + rng.uniform(0.0, 1.0, (107, 1)))
    level = np.repeat(rng.uniform(0.3, 1.0, samples // 500 + 1), 500)[:samples]
    u_V = 50.0 + level * np.cos(phases).sum(axis=0)
    return Record.from_arrays(u_V, run(stage, u_V, SOFT_TS_S, rest_V=50.0).displacement_um, fs_Hz=1.0 / SOFT_TS_S)


STILL = Stage(lag_s=2e-5, memory=None)


@pytest.mark.slow
def test_memory_in_the_loop_of_a_mode_is_named_extended_and_priced() -> None:
    """Iwan's elements in the plant, Duhem states in the model."""
    stage = STILL.with_effects(softening=SofteningEffect(SOFT_HZ, 0.02, yielding=0.5, yield_V=8.0))
    found = diagnose(record(stage, 1, 8000), record(stage, 2, 4000), DiagnoseSettings(price=price_of))
    assert found.names == ("resonance", "softening")
    cause = found.causes[1]
    # Two states stand for a continuum of elements: the smallest amplitudes are theirs to 3 %.
    assert cause.parameters["small_f_Hz"].value == pytest.approx(SOFT_HZ, rel=0.05)
    assert cause.parameters["f_Hz"].value < 0.8 * SOFT_HZ
    assert cause.price is not None
    assert (cause.price.cycles or 0) > 100
    assert found.extended_rms_um < 0.05 * found.base_rms_um
    loop = found.model.blocks[-1]
    assert isinstance(loop, Loop)
    assert _last_step_um(loop) < 1e-3 * min(loop.box_um)


@pytest.mark.slow
def test_a_mode_of_one_frequency_is_a_resonance_alone() -> None:
    mode = STILL.with_effects(resonance=ResonanceEffect(SOFT_HZ, 0.02, 1.0))
    assert name_causes(record(mode, 1, 8000)).names == ("resonance",)


def _last_step_um(loop: Loop) -> float:
    """Largest step after 0.6 s at constant input from 1000 random states of the box: no certificate says it settles."""
    rng, still = np.random.default_rng(4), np.zeros(1000, dtype=np.float32)
    mirror = loop.mirror(still, SOFT_TS_S)
    mirror.position, mirror.velocity, *mirror.h = (
        rng.uniform(-1.0, 1.0, (2 + len(loop.box_um), still.size))
        * np.array([[loop.box_um[0]] * 2 + list(loop.box_um)]).T
    ).astype(np.float32)
    for _ in range(6000):
        before = mirror.position
        mirror.apply(still)
    return float(np.abs(mirror.position - before).max())


def alone(record: Record, start: int, stop: int) -> Record:
    """The rows as a file of its own has them: without what was before."""
    return Record.from_arrays(record.u_V[start:stop], record.y_um[start:stop], record.Ts_s)


def test_rows_of_a_held_out_file_that_its_unknown_past_spoils_are_not_scored() -> None:
    """The input comes to a large extreme after three fifths of the held-out file; before it, the plays are unknown."""
    k = np.arange(6000)
    u_V = 30.0 + np.where(k < 5000, 25.0, 5.0) * np.sin(0.01 * k)
    u_V[5600:5800] = 30.0 + 20.0 * np.sin(np.pi * (k[5600:5800] - 5600) / 100.0)
    y_um = 0.1 * u_V + 1e-3 * np.random.default_rng(1).normal(size=k.size)
    record = Record.from_arrays(u_V, y_um, 1e-4)
    known, unseen = alone(record, 0, 5000), alone(record, 5000, 6000)
    held = prepare(known, unseen).held_rows
    assert held.min() >= 5650
    # With its past, every row is scored.
    assert prepare(*record.split_at(5000)).held_rows.min() == 5000


@pytest.mark.proof
def test_memory_is_extended_on_a_record_that_was_cut_by_hand(tmp_path: Path) -> None:
    """Rows of the bundled record cut at 65 %, the rest a file of its own: with its first, memory seemed to do harm."""
    (tmp_path / "record.csv").write_text(bundled_csv())
    record = load_record(tmp_path / "record.csv")
    last = 24_000
    cut = round(0.65 * last)
    found = diagnose(alone(record, 0, cut), alone(record, cut, last), DiagnoseSettings())
    assert "memory" in {cause.name for cause in found.causes if cause.extended}
    assert found.extended_rms_um < 0.2 * found.base_rms_um


MOST_WRONG = 5
"""Of fifty records: with 95 % of them right, more are wrong once in twenty-five times."""


@pytest.mark.proof
def test_hidden_effects_are_named_on_foreign_stages() -> None:
    wrong = {}
    for family in FAMILIES:
        for seed, effect in enumerate(EFFECTS):
            names = name_causes(foreign_record(family, effect, seed)).names
            if set(names) != {"memory", *filter(None, [effect])}:
                wrong[family, effect] = names
    assert len(wrong) <= MOST_WRONG, wrong


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.proof) for seed in (1, 2))])
@pytest.mark.parametrize("family", sorted(FAMILIES.keys() - {"Landau"}))  # docs/diagnosis.md, "What falls short"
@pytest.mark.parametrize("mode", [False, True])
def test_what_repeats_with_the_command_may_be_misfit_and_is_no_mode_until_it_rings(
    family: str, mode: bool, seed: int
) -> None:
    names = name_causes(repeating_record(family, seed, mode)).names
    assert set(names) == ({"memory", "resonance"} if mode else {"memory"})


@pytest.mark.slow
def test_the_sensor_of_another_axis_is_said_and_its_model_has_no_c() -> None:
    u_V = good(np.random.default_rng(4), 9000, 0.0, 100.0)
    t_s = 2.5e-4 * np.arange(u_V.size)
    lines_um = 1.1 * np.sin(2.0 * np.pi * 7.0 * t_s) + 0.4 * np.sin(2.0 * np.pi * 19.0 * t_s + 1.0)
    y_um = lines_um + lfilter([0.0, 1e-3], [1.0, -0.8], u_V) + 1e-3 * np.random.default_rng(5).normal(size=u_V.size)
    study = hysgen.diagnose(Record.from_arrays(u_V, y_um, 2.5e-4))
    assert "resonance" not in study.names
    assert not study.follows_voltage
    assert "does not follow the voltage" in "\n".join(verdict(study))
    with pytest.raises(ModelError, match="lines that do not depend on the voltage"):
        hysgen.generate(scored_extension(study))


@pytest.mark.slow
@pytest.mark.parametrize("bow_um", [3.0, -0.04, 0.0], ids=["wide", "narrow", "straight"])
def test_a_stage_that_bends_and_does_not_remember_is_a_curve_and_its_gain_is_measured(bow_um: float) -> None:
    u_V = good(np.random.default_rng(8), 8000, 0.0, 100.0)
    bent_um = 0.1 * u_V + bow_um * np.sin(np.pi * u_V / 100.0)
    y_um = lfilter([0.0, 0.25], [1.0, -0.75], bent_um) + 2e-3 * np.random.default_rng(9).normal(size=u_V.size)
    found = diagnose(Record.from_arrays(u_V, y_um, 2.5e-4))
    assert found.names == (("curve",) if bow_um else ())
    assert found.remaining.rms_um < 1.5 * found.noise.rms_um
    for cause in found.causes:
        assert cause.parameters["bow_um"].value == pytest.approx(bow_um, rel=0.01)
        assert cause.confidence is not None
        assert cause.confidence > 0.99
