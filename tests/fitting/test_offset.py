"""A constant on which the displacement stands changes no result, and float32 says where it no longer resolves it."""

import dataclasses

import numpy as np
import pytest

import hysgen
from hysgen.errors import ModelError
from hysgen.model.model import Grid
from hysgen.record import Record

K = np.arange(1800)
U_V = np.round(50.0 * (1.0 - np.cos(0.046 * K)) * (0.4 + 0.6 * np.cos(0.0021 * K) ** 2), 4)


def record_at(level_um: float) -> Record:
    plays, y = np.zeros(2), np.zeros(K.size)
    for k in range(1, K.size):
        plays = np.clip(plays, U_V[k - 1] - (8.0, 25.0), U_V[k - 1] + (8.0, 25.0))
        y[k] = y[k - 1] + 0.28 * (0.05 * U_V[k - 1] + 0.012 * plays.sum() - y[k - 1])
    y += 5e-4 * np.random.default_rng(7).normal(size=y.size)
    return Record.from_arrays(U_V, y + level_um, 1e-3)


def free_run_um(level_um: float, memory: bool) -> tuple[hysgen.Model, float]:
    known, unseen = record_at(level_um).split_at(1200)
    model = hysgen.fit(known, memory=memory)
    return model, hysgen.score(model, unseen).free_run.e_rms_um


@pytest.mark.parametrize("memory", [False, True])
def test_the_free_run_does_not_depend_on_an_offset(memory: bool) -> None:
    _, at_zero_um = free_run_um(0.0, memory)
    for level_um in (-12_345.6, 1e6):
        model, rms_um = free_run_um(level_um, memory)
        assert rms_um == pytest.approx(at_zero_um, rel=0.05)
        assert model.grid.y_min_um == pytest.approx(level_um, abs=0.1)
        assert model.history["record"]["digest"] == record_at(level_um).rows(0, 1200).digest


def test_a_range_asked_for_stands_as_high_as_the_record() -> None:
    model = hysgen.fit(record_at(1e3), displacement_range_um=(990.0, 1010.0))
    assert (model.grid.y_min_um, model.grid.y_max_um) == (990.0, 1010.0)


@pytest.mark.slow
def test_a_diagnosis_names_the_same_causes_at_any_offset() -> None:
    studies = [hysgen.diagnose(record_at(level_um)) for level_um in (0.0, 12_345.0)]
    assert studies[0].names == studies[1].names != ()
    assert studies[1].diagnosis.extended_rms_um == pytest.approx(studies[0].diagnosis.extended_rms_um, rel=0.05)
    assert studies[1].model.grid.y_min_um > 12_340.0


@pytest.mark.parametrize(("level_um", "refused"), [(0.0, False), (1e3, False), (12_345.0, True)])
def test_generate_refuses_where_float32_does_not_resolve_half_the_noise(level_um: float, refused: bool) -> None:
    record = record_at(level_um)
    model = hysgen.fit(record)
    scores = hysgen.score(model, record).to_json()
    model = dataclasses.replace(model, scores={"identification": scores})
    if not refused:
        assert hysgen.generate(model)
        return
    with pytest.raises(
        ModelError, match=r"float32 has steps of 0\.000977 um, more than half the noise \(0\.0002\d+ um\); take 12"
    ):
        hysgen.generate(model)
    for end_um in (3e38, 1e39, 1e200):
        with pytest.raises(ModelError, match="is beyond float32; give it in a larger unit"):
            hysgen.generate(dataclasses.replace(model, grid=Grid(1.0, end_um, 6)))


def test_the_echo_shows_the_stroke_beside_a_large_offset() -> None:
    assert "um + 0 .. 6." in record_at(123_456.0).one_line()
    assert "+ 0 .." not in record_at(10.0).one_line()
