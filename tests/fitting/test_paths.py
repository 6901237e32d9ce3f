"""Paths fitted: a past of creep, plays that relax, a hysteresis that may fall; a refit, which changes only numbers."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from fixtures.generated_models import relaxing
from hysgen.api.code import _as_before, generate
from hysgen.api.diagnosing import diagnose
from hysgen.certify.certificates import certify
from hysgen.codegen import Options
from hysgen.codegen import generate as texts_of
from hysgen.codegen.manifest import write
from hysgen.diagnosis import DiagnoseSettings
from hysgen.errors import CertificateError
from hysgen.fitting import FitSettings, PathSize, fit, known_past, path_columns, path_model
from hysgen.fitting.identify import path_task
from hysgen.fitting.operator import SEARCHED
from hysgen.fitting.refit import refit
from hysgen.model.file import dump_model, parse_model
from hysgen.model.path.creep import Creep
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.limits import Slew
from hysgen.model.scores import score
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.families import command
from hysgen_lab.stage.signals import nested_amplitudes
from hysgen_lab.studies.bank.scenario import good

TS_S, CREEP = 1e-3, (0.02, 0.05, 1e4)


@pytest.mark.parametrize("past_V", [100.0, 60.0])
def test_what_creep_adds_from_an_earlier_level_is_that_of_the_stage_and_not_in_the_model(past_V: float) -> None:
    u_V = good(np.random.default_rng(2), 20_000, 0.0, 100.0)
    stage = Stage.nominal().with_effects(creep=CREEP)
    before_V = np.full(500, past_V)
    moved = run(stage, np.concatenate([before_V, u_V]), TS_S, seed=2).displacement_um[before_V.size :]
    rested = run(stage, u_V, TS_S, seed=3).displacement_um
    record = Record.from_arrays(u_V, moved, TS_S)
    weights = known_past(record)
    rows = np.flatnonzero(weights[0])
    true_um = (moved - rested)[rows]
    creep = Creep.logarithmic(CREEP[0], CREEP[1], 10.0 * TS_S * u_V.size)
    settings = FitSettings(memory=PathSize(plays=4, hats=4, states=2), blocks=(creep,), past=(past_V, TS_S))
    model, crept_um = path_model(path_columns(path_task(record, settings), weights), weights)
    # The level is the mean of both branches of the loop; the stage rested on one of them.
    assert np.std(crept_um[0][rows] - true_um) < 0.2 * np.std(true_um)
    assert crept_um[0][-1] == 0.0  # what is left at the end is the level of the model
    left_um = model.simulate(u_V)[rows] - moved[rows]
    assert np.std(left_um + crept_um[0][rows]) < 0.5 * np.std(left_um)


TAU_S = 5e-3


def measured(relaxation: float, seed: int, plays_um: tuple[float, ...] = relaxing().plays_um) -> Record:
    """4000 samples of five plays behind a lag, with a noise of 0.1 nm."""
    rng = np.random.default_rng(seed)
    u = command(rng, 4000, -20.0, 120.0, 50.0)
    w = dataclasses.replace(relaxing(), relaxation=relaxation, duhem_um=(), plays_um=plays_um).apply(u, TS_S)
    a, y = np.exp(-TS_S / TAU_S), np.empty_like(w)
    y[0] = w[0]
    for k in range(len(w) - 1):
        y[k + 1] = a * y[k] + (1.0 - a) * w[k]
    return Record.from_arrays(u, y + 1e-4 * rng.standard_normal(len(y)), Ts_s=TS_S)


@pytest.mark.slow
def test_the_fit_finds_the_relaxation_and_refit_keeps_its_search() -> None:
    known, fresh = measured(0.03, 1), measured(0.03, 2)
    sizes = [PathSize(plays=8, states=0, relaxation=relaxation) for relaxation in (SEARCHED, 0.0)]
    found, rigid = (fit(known, FitSettings(method="batch", memory=size)) for size in sizes)
    block = next(block for block in found.blocks if isinstance(block, Hysteresis))
    # Half-widths of the fit are not those of the plant, so the relaxation is not exact.
    assert 0.022 < block.relaxation < 0.04
    assert score(found, fresh).free_run.e_rms_um < 0.5 * score(rigid, fresh).free_run.e_rms_um
    again = parse_model(dump_model(found), "found")
    assert again.blocks == found.blocks
    renewed, _ = refit(again, measured(0.045, 3))
    block = next(block for block in renewed.blocks if isinstance(block, Hysteresis))
    assert 0.034 < block.relaxation < 0.06


def test_no_fitted_density_is_negative_even_where_that_of_the_stage_is() -> None:
    plays_um = np.array(relaxing().plays_um).reshape(5, 3)
    plays_um[2, 0] = -0.3
    record = measured(0.03, 4, tuple(plays_um.ravel().tolist()))
    model = fit(record, FitSettings(method="batch", memory=PathSize(plays=5, states=1, hats=5, relaxation=0.03)))
    block = next(block for block in model.blocks if isinstance(block, Hysteresis))
    for row, end in zip(block.series.plays, block.ends, strict=True):
        z = np.linspace(-end, end, 501)
        slopes = chebyshev.chebval(z, chebyshev.chebder(np.array([0.0, *row])))
        assert slopes.min() > -1e-3 * block.mean_slope
    b, c = block.duhem_um
    assert min(b, b + 2.0 * c) > -1e-3 * block.mean_slope
    slopes = certify(model).path.slopes
    assert slopes is not None
    assert slopes.proved


NOISE_UM = 2e-3
SIZE = PathSize(plays=16)


def against(u_V: NDArray[np.float64]) -> Record:
    """0.12 u + 2 atan(s / 6 V), s: voltage since the last turn, falling as it rises; slope 0.12 - 0.33 um/V there.

    Madelung's first rule alone: the branch from a turn depends on the turn, not on what was before it.
    """
    s_V = np.zeros(len(u_V))
    for k in range(1, len(u_V)):
        du_V = u_V[k] - u_V[k - 1]
        s_V[k] = s_V[k - 1] + du_V if du_V * s_V[k - 1] >= 0.0 else du_V
    noise_um = NOISE_UM * np.random.default_rng(5).standard_normal(len(u_V))
    return Record.from_arrays(u_V, 0.12 * u_V - 2.0 * np.arctan(s_V / 6.0) + noise_um, TS_S)


@pytest.fixture(scope="module")
def record() -> Record:
    return against(good(np.random.default_rng(11), 6000, 0.0, 100.0))


def left_um(record: Record, settings: FitSettings) -> float:
    """rms of the free run in um over the rows that the fit has not seen."""
    known, later = record.split(0.65)
    return float(np.sqrt(np.mean((free_run(fit(known, settings), later)[0].y_um - later.segments[0].y_um) ** 2)))


def test_a_hysteresis_that_may_fall_predicts_what_a_rising_one_cannot(record: Record) -> None:
    rising_um = left_um(record, FitSettings(memory=SIZE))
    falling_um = left_um(record, FitSettings(memory=SIZE, rising=False))
    assert falling_um < 0.5 * rising_um, (falling_um, rising_um)


def test_its_c_has_no_inverse_and_an_inverse_that_is_asked_for_is_refused(record: Record) -> None:
    model = fit(record, FitSettings(name="against", memory=SIZE, rising=False))
    texts = generate(model).texts
    assert "against_predict" in texts["against.h"]
    assert "against_inverse" not in texts["against.h"]
    with pytest.raises(CertificateError, match="a voltage may not exist"):
        generate(model, Options(inverse=True))


@pytest.mark.slow
def test_the_answer_says_what_the_inverse_costs(record: Record) -> None:
    said = diagnose(record).diagnosis.remaining
    assert "--predict-only" in said.reason
    predicts = diagnose(record, settings=DiagnoseSettings(fit=FitSettings(rising=False))).diagnosis.remaining
    assert predicts.rms_um < 0.8 * said.rms_um
    assert "--predict-only" not in predicts.reason


REFIT_TS_S = 1e-4


def record_of(stage: Stage, seed: int) -> Record:
    u_V = nested_amplitudes(REFIT_TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    return Record.from_arrays(u_V, run(stage, u_V, REFIT_TS_S, seed).displacement_um, REFIT_TS_S, source=f"seed {seed}")


@pytest.fixture(scope="module")
def records() -> tuple[Record, Record]:
    """The stage, and the stage with an actuator that moves a tenth further."""
    stage = Stage.nominal()
    return record_of(stage, 1), record_of(dataclasses.replace(stage, stroke_um=1.1 * stage.stroke_um), 2)


@pytest.mark.slow
def test_refit_fits_the_whole_record_and_keeps_the_ranges_of_a_restricted_model_and_of_a_folder(
    records: tuple[Record, Record], tmp_path: Path
) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    whole, _ = refit(old, records[1])
    part = old.within((old.grid.y_min_um + 0.3, old.grid.y_max_um - 0.3), (0.5 * old.u_max_V, 0.75 * old.u_max_V))
    code = texts_of(part)
    write(code, tmp_path)
    for again in (refit(part, records[1])[0], _as_before(whole, tmp_path)[0]):
        assert (again.grid.y_min_um, again.grid.y_max_um) == (part.grid.y_min_um, part.grid.y_max_um)
        assert (again.u_min_V, again.u_max_V, again.grid.ends_um) == (part.u_min_V, part.u_max_V, whole.grid.ends_um)
        np.testing.assert_array_equal(again.parameters, whole.parameters)
        assert texts_of(again)["axis.c"] == code["axis.c"]


def test_a_command_that_the_amplifier_does_not_follow_covers_no_range_and_hides_no_rows() -> None:
    rise_V = 0.5  # a sample
    slow_V = np.interp(np.arange(3000), [0, 400, 900, 1500, 2200, 3000], [50.0, 90.0, 5.0, 80.0, 30.0, 50.0])
    fast_V = 50.0 + np.linspace(10.0, 50.0, 6000) * np.sin(np.arange(6000) * 2.0 * np.pi / 40.0)
    u_V = np.concatenate([slow_V, fast_V])
    stage = Stage.nominal().with_effects(slew=rise_V / TS_S)
    record = Record.from_arrays(u_V, run(stage, u_V, TS_S, seed=1).displacement_um, TS_S)
    slew = Slew(rise_V / TS_S, rise_V / TS_S)
    first = [int(np.flatnonzero(known_past(record, blocks=blocks)[0])[0]) for blocks in ((), (slew,))]
    assert first[0] > 2500, "the command covers its range where the amplifier stands still"
    assert first[1] < 1000
    error_um = (
        free_run(fit(record, FitSettings(memory=PathSize(), blocks=(slew,))), record)[0].y_um - record.segments[0].y_um
    )
    assert np.sqrt(np.mean(error_um[1000:3000] ** 2)) < 0.005 * float(np.ptp(record.segments[0].y_um))
