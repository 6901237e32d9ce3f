"""The float32 learner is Eq. (10) with the protections of docs/learning.md: float64, written independently, agrees."""

from typing import Any

import numpy as np
import pytest

from fixtures.learner_bench import START_UM, START_V, Floats32, Pair, lagging, sized
from fixtures.learner_equations import Equations, Limits
from hysgen.errors import ModelError
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.model.model import Model

SAMPLES = 1100


def spoilt() -> tuple[Floats32, Floats32]:
    """A plant with everything in its record that a protection is there for."""
    y, u = lagging(SAMPLES, 3)
    y[101::397], y[205::331], u[57::433], u[88::517] = np.nan, 1e30, np.inf, 1e6
    y[60::97] += np.float32(0.4) * np.float32(1.2) ** np.arange(y[60::97].size, dtype=np.float32)
    y[300:320] = 9.5
    y[700:730] += np.where(np.arange(30) % 2, 0.9, -0.9).astype(np.float32)
    u[850:] = u[850]
    return y, u


SCENARIOS: dict[str, tuple[dict[str, Any], float, set[str]]] = {
    "worse than persistence": ({"settle": 200, "worse": 1.01, "lost": 1.0}, 1e-4, {"restarts", "outliers"}),
    "worse than the reference": ({"settle": 200, "lost": 1e3}, 1e-4, {"restarts", "outliers"}),
    "rest and change": (
        {"settle": 400, "rest_V": 2.0, "noise_um": 0.01, "outlier_ratio": 4.0, "outlier_run": 5},
        1e-4,
        {"resting", "outliers", "changes", "quiet"},
    ),
    "dead zone": ({"dead_zone_um": 5e-3}, 1e-4, {"quiet"}),
    "no prior, short steps": ({"alpha": 1e3, "step_um": 0.02, "settle": 64}, 2e-3, {"limited", "restarts"}),
    "a window, then sliding": ({"forgetting": 1.0, "window": 1024, "alpha": 1.0, "limit_um": 30.0}, 1e-4, set()),
    "small parameters": ({"limit_um": 4.0}, 1e-4, {"restarts"}),
}
"""Settings, allowed difference of theta [um] (float32 through a thousand updates), and events that must occur."""


@pytest.mark.slow
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_learner_is_the_equations_and_protections_in_float64(scenario: str) -> None:
    """Every counter after every sample, theta and the running means within float32, and the C in the same bits."""
    settings, allowed_um, events = SCENARIOS[scenario]
    pair = Pair(sized(6, **settings))
    lane, truth = pair.lane, Equations(pair.model, float(START_UM), float(START_V))
    # The running means of innovation and step start where a settled learner has them, far below the range.
    lane.scale_um[:] = lane.moving_um[:] = truth.scale = truth.moving = 0.01
    pair.learner.scale_um = pair.learner.moving_um = 0.01
    if scenario == "worse than the reference":  # a shadow that is off and has a covariance too small to learn
        lane.theta *= np.float32(1.2)
        lane.d[:], truth.theta, truth.P = 2.0**-30, lane.theta[:, 0].astype(np.float64), np.eye(6) * 2.0**-30
        for i, value in enumerate(lane.theta[:, 0]):
            pair.learner.theta[i], pair.learner.d[i] = float(value), 2.0**-30
    lane.trial, truth.on_trial = np.float32(0.9) * lane.reference, 0.9 * truth.reference
    lane.trying[:] = truth.trying = pair.learner.trying = 700
    for i, value in enumerate(lane.trial[:, 0]):
        pair.learner.trial[i] = float(value)
    y, u = spoilt()
    compiled = pair.run(y, u)
    for k in range(SAMPLES):
        lane.learn(y[k : k + 1], u[k : k + 1])
        truth.learn(float(y[k]), float(u[k]))
        assert {name: int(count[0]) for name, count in lane.counters.items()} == {
            name: truth.counters[name] for name in lane.counters
        }, f"sample {k}"
        assert np.abs(lane.theta[:, 0] - truth.theta).max() < allowed_um, f"sample {k}"
        means = (lane.scale_um, lane.moving_um, lane.error, lane.reference_error, lane.step_error, lane.mean_u_V)
        expected = (truth.scale, truth.moving, truth.error, truth.reference_error, truth.step_error, truth.mean_V)
        means += (lane.trial_um, lane.trial_reference_um, lane.trial_error, lane.trial_reference_error)
        expected += (*truth.free_run, *truth.squares)
        np.testing.assert_allclose(np.concatenate(means), expected, rtol=1e-4, atol=1e-9, err_msg=f"sample {k}")
        assert (lane.age[0], lane.run[0], lane.turn[0], lane.trying[0]) == (
            truth.age,
            truth.run,
            truth.turn,
            truth.trying,
        )
        assert k % 8 or (compiled[k] == pair.expected()).all(), f"sample {k}"
    upper = lane.u[:, :, 0] + np.eye(6)
    np.testing.assert_allclose(upper * lane.d[:, 0] @ upper.T, truth.P, rtol=0, atol=1e-4 * np.abs(truth.P).max())
    assert {name for name in truth.counters if truth.counters[name]} >= {"updates", "rejected", "outside", *events} - (
        {"updates"} if scenario == "small parameters" else set()
    )


@pytest.mark.parametrize(
    ("planted", "event", "restarts"), [(1.4, "clamped", 0), (2.0**-45, "clamped", 0), (1e30, "restarts", 1)]
)
def test_variances_stay_between_their_limits_and_a_wild_one_restarts(planted: float, event: str, restarts: int) -> None:
    """D as a flipped bit would leave it: 1.4 times the ceiling, below 2^-40 and beyond what an update can make."""
    lane = Pair(sized(6)).lane
    numbers = lane.numbers
    lane.d[:] = planted * numbers.ceiling[:, None] if planted == 1.4 else planted
    y, u = lagging(3)
    for k in range(3):
        lane.learn(y[k : k + 1], u[k : k + 1])
    assert lane.counters["restarts"] == restarts
    assert lane.counters[event] >= 1
    assert lane.status[0] == lane.COUNTERS[event].flag
    assert (lane.d[:, 0] <= numbers.ceiling).all()
    assert (lane.d >= 2.0**-40).all()


@pytest.mark.parametrize("model", [sized(6), sized(18, forgetting=1.0, alpha=1e3, noise_um=1e-3, worse=1.3, lost=3.0)])
def test_numbers_of_the_learner_are_what_the_stage_and_its_settings_say(model: Model) -> None:
    numbers, limits, s = learner_numbers(model, coefficients(model)), Limits(model), model.learner
    assert s is not None
    grid = model.grid
    for found, expected in (
        (numbers.scale, limits.scale),
        (numbers.per_scale, 1.0 / limits.scale),
        (numbers.prior, limits.prior),
        (numbers.ceiling, limits.ceiling),
        (numbers.refresh, limits.restoring),
        (numbers.largest_denominator, limits.largest_alpha),
        ((numbers.y_low_um, numbers.y_high_um), (grid.y_min_um - limits.span_um, grid.y_max_um + limits.span_um)),
        ((numbers.rest_V, numbers.dead_zone_um), (limits.rest_V, limits.dead_zone_um)),
        ((numbers.step_um, numbers.limit_um), (limits.step_um, limits.limit_um)),
        ((numbers.floor_um, numbers.gate_floor_um, numbers.level_um), (s.noise_um / 8, 6 * s.noise_um, limits.span_um)),
        ((numbers.gate_ratio, numbers.worse, numbers.lost), (s.outlier_ratio, limits.worse, s.lost**2)),
        ((numbers.inflate_first, numbers.inflate), (1 / s.forgetting, 1 / limits.forgetting)),
    ):
        np.testing.assert_allclose(found, expected, rtol=3e-7, atol=2.0**-30)  # the grid of regressors


def test_what_forgetting_removes_of_the_prior_is_restored_and_half_the_ceiling_is_reached() -> None:
    """Without excitation: 1/P of a parameter when its turn comes, and after its restoration."""
    numbers = learner_numbers(model := sized(18), coefficients(model))
    kept = float(numbers.inflate) ** -(numbers.size * (numbers.settings.refresh - 1))
    prior, restored = numbers.prior.astype(np.float64), kept / numbers.prior + numbers.refresh.astype(np.float64) ** 2
    np.testing.assert_allclose(1.0 / restored, prior, rtol=1e-5)
    np.testing.assert_allclose(prior / kept, numbers.ceiling / 2.0, rtol=1e-5)


def test_a_prior_that_is_forgotten_between_two_restorations_is_refused() -> None:
    model = sized(24, forgetting=0.95, refresh=8)
    with pytest.raises(ModelError, match="24 parameters and refresh 8 loses the prior"):
        learner_numbers(model, coefficients(model))
