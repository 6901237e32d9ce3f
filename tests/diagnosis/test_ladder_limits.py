"""What holds a rung of the ladder back: the range of its grid, and the limits that its gain must stay inside."""

import numpy as np
import pytest

from fixtures.bank_records import built, measured, prepared_of
from hysgen.certify.certificates import certify
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import GainChange
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import checked_errors, fit_ladder, levelled
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, linear_fit, rms
from hysgen.fitting import FitSettings
from hysgen.model.disturbances.coupling import Coupling
from hysgen.record import Record
from hysgen_lab.studies.bank.scenario import good, true_extensions

FULL_STROKE_V = 50.0 - 50.0 * np.cos(2.0 * np.pi * np.arange(400) / 400.0)


def test_the_grid_covers_an_aged_stage_before_and_after_the_aging() -> None:
    """Fitted is the displacement with the aging taken out: a gain that falls by 8 % puts it above what was measured."""
    u_V = good(np.random.default_rng(5), 6000, 0.0, 80.0)
    u_V[3400:3800] = FULL_STROKE_V
    hidden = built(u_V, aging=(-0.08, 6.0))
    prepared = prepare(measured(hidden))
    new = Extension(correction=GainChange(-0.08 / 6.0))
    level_um = np.concatenate([segment.y_um for segment in levelled(prepared, [new]).segments])
    assert level_um.max() > prepared.y_um.max() + 0.2
    rung = fit_ladder(prepared, true_extensions(hidden) | {"aging": new}, ["memory", "aging"], FitSettings())
    grid = rung.model.grid
    assert grid.y_min_um <= level_um.min()
    assert level_um.max() <= grid.y_max_um
    assert rms(rung.error_um[prepared.held_rows]) < 3.0 * rms(rung.error_um[prepared.training_rows])


def test_a_corrupted_last_reading_changes_no_model() -> None:
    record = measured(built())
    segment = record.segments[0]
    wild_um = segment.y_um.copy()
    wild_um[prepare(record).cut - 1] -= 0.4  # inside the range of the rest
    weights = []
    for seen_um in (segment.y_um, wild_um):
        prepared = prepare(Record.from_arrays(segment.u_V, seen_um, record.Ts_s))
        weights.append(fit_ladder(prepared, {}, [], FitSettings()).model.parameters)
    assert np.abs(weights[1] - weights[0]).max() < 1e-6 * np.abs(weights[0]).max()


def test_the_top_of_the_first_stroke_is_fitted_if_the_held_out_part_returns_to_it() -> None:
    """Only the first stroke and one behind the cut go above 80 V."""
    u_V = good(np.random.default_rng(5), 6000, 0.0, 80.0)
    u_V[:400] = u_V[4800:5200] = FULL_STROKE_V
    hidden = built(u_V)
    prepared = prepare(measured(hidden))
    assert prepared.cut < 4800
    rung = fit_ladder(prepared, true_extensions(hidden), ["memory"], FitSettings())
    assert rms(rung.error_um[prepared.held_rows]) < 0.005 * np.ptp(prepared.y_um)


@pytest.mark.slow
def test_a_mode_that_no_inverse_can_follow_is_simulated_all_the_same() -> None:
    """A lightly damped mode without a stiff share has no stable inverse; that must not press on the model."""
    hidden = built(lag_s=8e-3, resonance=(48.0, 0.034, 0.67))
    prepared, extensions = prepare(measured(hidden)), true_extensions(hidden)

    def left_um(names: list[str]) -> float:
        return rms(checked_errors(prepared, [(extensions, names)], FitSettings())[0][1])

    assert left_um(["memory", "resonance"]) < 0.2 * left_um(["memory"])
    found = certify(fit_ladder(prepared, extensions, ["memory", "resonance"], FitSettings()).model)
    assert found.gain_holds
    assert found.contraction_holds
    assert found.inverse_holds


def test_the_grid_reaches_where_the_command_leads_on_rows_that_are_held_out() -> None:
    """On at least seven of eight drawn stages, by the command alone, and by no more than 20 % of what is measured."""
    reached = []
    for seed in range(8):
        prepared = prepared_of("memory", seed)
        low, high = prepared.predicted_range_um
        held_um = prepared.y_um[prepared.held_rows]
        assert high - low < 1.2 * np.ptp(prepared.y_um)
        reached.append(low <= held_um.min() and held_um.max() <= high)
    assert sum(reached) >= 7


def test_the_range_of_a_channel_is_that_of_the_whole_record() -> None:
    channel = np.linspace(-1.0, 1.0, 6000) ** 3 + np.sin(np.arange(6000) / 90.0)
    hidden = built(aux={"axis2_V": channel}, coupling={"axis2_V": 0.05})
    prepared = prepare(measured(hidden))
    assert np.ptp(channel) > np.ptp(channel[: prepared.cut])
    scene = prepared.scene()
    extension = causes()["coupling"].extension(
        Residual(scene, linear_fit(scene, Chain(0.08, (Coupling.of({"axis2_V": scene.range_of("axis2_V")}),))))
    )
    assert extension.term is not None
    assert extension.term.to_json() | {"low": [channel.min()], "high": [channel.max()]} == extension.term.to_json()
