"""What holds a rung of the ladder back: the range of its grid, and the limits that its gain must stay inside."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from fixtures.bank_records import measured
from hysgen.certify.certificates import certify
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import GainChange
from hysgen.diagnosis.causes.coupling import CouplingPart
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import checked_error, fit_ladder, levelled
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, linear_fit, rms
from hysgen.fitting import FitSettings
from hysgen.model.terms.memory import Memory
from hysgen.record import Record
from hysgen.stage import Aging
from hysgen.stage import run as measure
from hysgen.studies.bank.scenario import scenario
from hysgen.studies.bank.truth import true_extensions


def test_the_grid_covers_a_stage_that_has_aged_as_it_was_when_it_was_new() -> None:
    # The gain falls by 8 %: what is fitted, the displacement with the aging taken out, goes beyond what was measured.
    hidden = scenario("aging", 1117)
    aging = hidden.stage.one(Aging)
    assert aging is not None
    prepared = prepare(measured(hidden))
    new = Extension(correction=GainChange(aging.fraction / aging.over_s))
    level_um = np.concatenate([segment.y_um for segment in levelled(prepared, [new]).segments])
    assert level_um.max() > prepared.y_um.max() + 1.0
    rung = fit_ladder(prepared, true_extensions(hidden) | {"aging": new}, ["memory", "aging"], FitSettings())
    grid = rung.model.grid
    assert grid.y_min_um <= level_um.min()
    assert level_um.max() <= grid.y_max_um
    late = prepared.held_rows
    assert rms(rung.error_um[late]) < 3.0 * rms(rung.error_um[prepared.training_rows])


def test_a_corrupted_last_reading_moves_no_model() -> None:
    hidden = scenario("memory", 1310)
    y_um = measure(hidden.stage, hidden.u_V, hidden.Ts_s, hidden.seed).displacement_um
    cut = prepare(measured(hidden)).cut
    wild_um = y_um.copy()
    wild_um[cut - 1] -= 0.4  # inside the range of the rest
    weights = []
    for seen_um in (y_um, wild_um):
        prepared = prepare(Record.from_arrays(hidden.u_V, seen_um, hidden.Ts_s))
        weights.append(fit_ladder(prepared, {}, [], FitSettings()).model.parameters)
    assert np.abs(weights[1] - weights[0]).max() < 1e-6 * np.abs(weights[0]).max()


def test_the_top_of_the_first_stroke_is_fitted_where_the_held_out_part_goes_there_again() -> None:
    # Nothing else before the cut goes above 1.91 of 2.25 um.
    hidden = scenario("memory", 1310)
    prepared = prepare(measured(hidden))
    rung = fit_ladder(prepared, true_extensions(hidden), ["memory"], FitSettings())
    assert rms(rung.error_um[prepared.held_rows]) < 0.01


@pytest.mark.parametrize("name", ["pair:1013", "resonance:1106"])
def test_a_mode_that_takes_nearly_all_of_the_gain_does_not_make_the_model_worse(name: str) -> None:
    # One rule beside the mode has a gain of next to nothing, and so would have the limits that are multiples of it.
    category, seed = name.split(":")
    hidden = scenario(category, int(seed))
    hidden = dataclasses.replace(hidden, stage=hidden.stage.with_effects(outliers=None, drift=None, aging=None))
    prepared = prepare(measured(hidden))
    low_V, high_V = prepared.record.u_range_V
    extensions = true_extensions(hidden) | {"memory": Extension(term=Memory.polynomial(6, 3, low_V, high_V, True))}
    causes = [cause for cause in hidden.planted if cause in extensions]
    without, beside = (
        rms(fit_ladder(prepared, extensions, names, FitSettings()).error_um[prepared.training_rows])
        for names in ([cause for cause in causes if cause != "resonance"], causes)
    )
    assert beside < 1.02 * without


def test_a_model_that_only_simulates_keeps_to_rows_it_has_not_seen_and_follows_a_mode_that_no_inverse_could() -> None:
    hidden = scenario("resonance", 1001)
    prepared, extensions = prepare(measured(hidden)), true_extensions(hidden)

    def left_um(names: list[str], settings: FitSettings) -> float:
        return rms(checked_error(prepared, extensions, names, settings)[1])

    simulating, free, inverted = FitSettings(loop_limit=math.inf), FitSettings(certified=False), FitSettings()
    memory, both = ["memory"], ["memory", "resonance"]
    assert left_um(both, simulating) < 0.6 * left_um(memory, simulating)
    assert left_um(both, inverted) > 0.9 * left_um(memory, inverted)
    assert left_um(both, free) > left_um(memory, free)
    model = fit_ladder(prepared, extensions, both, simulating).model
    found = certify(model)
    assert found.gain_holds
    assert found.contraction_holds
    assert not found.inverse_holds


def test_a_channel_that_goes_further_behind_the_cut_is_not_held_at_the_edge_of_what_was_seen() -> None:
    hidden = scenario("coupling", 1128)
    prepared = prepare(measured(hidden))
    channel = np.asarray(hidden.aux["axis2_V"])
    assert np.ptp(channel) > np.ptp(channel[: prepared.cut])
    scene = prepared.scene()
    extension = causes()["coupling"].extension(
        Residual(scene, linear_fit(scene, Chain(0.08, (CouplingPart(("axis2_V",)),))))
    )
    assert extension.term is not None
    assert extension.term.to_json() | {"low": [channel.min()], "high": [channel.max()]} == extension.term.to_json()
