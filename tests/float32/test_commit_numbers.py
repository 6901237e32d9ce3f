"""What commit lets pass, in gains and slopes of the stage, and the tables and bounds that it judges by, in float64."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.commit_border import answers
from fixtures.generated_models import smooth
from fixtures.learner_bench import sized
from hysgen.certify.certificates import certify
from hysgen.checking.bits.comparison import committer_of
from hysgen.errors import CertificateError
from hysgen.float32.coefficients import CommitNumbers, coefficients, commit_numbers
from hysgen.float32.struct_words import Commit
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.regression import memberships

Floats = NDArray[np.float64]


def numbers_of(model: Model) -> CommitNumbers:
    return commit_numbers(model, coefficients(model), certify(model))


def range_of_gain_and_steepest(model: Model) -> tuple[float, float, float]:
    """min |b|, max |b| and max |df/dy| over a fine grid of y and both ends of u, by central differences of f."""
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 20_001)
    q1, q2, q3 = model.consequents.T
    p, step = memberships(y, model.grid), y[1] - y[0]
    gain = np.abs(p @ q2)
    values = [p @ q1 * y + p @ q2 * u + p @ q3 for u in (model.w_range.low, model.w_range.high)]
    return float(gain.min()), float(gain.max()), max(float(np.abs(np.diff(f)).max() / step) for f in values)


def accepted(model: Model, group: str, factors: Floats) -> NDArray[np.uint32]:
    """The answer to the model's own parameters with those of `group` times each of `factors`."""
    committer = committer_of(model, factors.size)
    chosen = np.array([parameter.group == group for parameter in committer.learner.numbers.parameters])
    return answers(committer, (committer.learner.theta * np.where(chosen[:, None], factors, 1.0)).astype(np.float32))


@pytest.mark.parametrize("model", [sized(6), sized(18)], ids=lambda model: model.name)
def test_gains_from_half_the_weakest_to_four_times_the_strongest_are_committed(model: Model) -> None:
    """Within 2 %, what the bounds between the check points and the rounding take."""
    factors = np.array([-1.0, 0.0, 0.495, 0.51, 1.0, 3.9, 4.05, 1e3])
    refused = Commit.REFUSED_GAIN
    expected = [refused, refused, refused, *[Commit.COMMITTED] * 3, refused, refused]
    assert accepted(model, "gain", factors).tolist() == expected
    weakest, strongest, _ = range_of_gain_and_steepest(model)
    numbers = numbers_of(model)
    assert numbers.gain_floor == pytest.approx(0.5 * weakest, rel=1e-3)
    assert numbers.gain_ceiling == pytest.approx(4.0 * strongest, rel=1e-3)


def test_a_slope_up_to_an_eighth_of_the_models_distance_from_one_is_committed() -> None:
    """sized(6): every slope is scaled alike, and df/dy with it but for the parts of gain and offset."""
    model = sized(6)
    _, _, steepest = range_of_gain_and_steepest(model)
    limit = 1.0 - (1.0 - steepest) / 8.0
    numbers = numbers_of(model)
    assert 1.0 - numbers.slope_limit == pytest.approx(1.01 * (1.0 - limit), rel=1e-3)

    def steepest_of(factor: float) -> float:
        consequents = model.consequents * [factor, 1.0, 1.0]
        return range_of_gain_and_steepest(dataclasses.replace(model, consequents=consequents))[2]

    factors = np.linspace(1.0, 1.0 / steepest, 400)
    answer = accepted(model, "slope", factors)
    assert set(answer.tolist()) == {Commit.COMMITTED, Commit.REFUSED_SLOPE}
    last = factors[answer == Commit.COMMITTED].max()
    # What the check between the points adds, a quarter of the margin at most, and one step of the factors.
    assert limit - 0.25 * (limit - steepest) - 1e-3 < steepest_of(last) < limit


def with_learner(model: Model, **settings: float) -> Model:
    return dataclasses.replace(model, learner=LearnerSettings(**settings))  # type: ignore[arg-type]


def test_limits_that_the_model_itself_breaks_are_refused_with_their_numbers() -> None:
    weakest, _, steepest = range_of_gain_and_steepest(smooth(2))
    base = smooth(2)
    turned = dataclasses.replace(base, consequents=base.consequents * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]]))
    steep = dataclasses.replace(base, consequents=base.consequents * [1.2, 1.0, 1.0])
    for model, message in (
        (with_learner(base, slope_limit=steepest - 1e-4), f"not below the limit {steepest - 1e-4:.4g} that commit"),
        (with_learner(steep), "not below the limit 1 that commit keeps"),
        (
            with_learner(base, gain_floor_um_per_V=1.01 * weakest),
            r"gain_floor_um_per_V \S+ is not below the model's own",
        ),
        (with_learner(turned), "does not stay away from zero"),
        (
            with_learner(smooth(6), slope_limit=certify(smooth(6)).slope.bound + 1e-6),
            "512 check points are too far apart",
        ),
        (with_learner(smooth(12), points=4), "4 check points are too far apart"),
    ):
        with pytest.raises(CertificateError, match=message):
            numbers_of(model)
    assert numbers_of(with_learner(base, gain_floor_um_per_V=0.9 * weakest)).gain_floor == np.float32(0.9 * weakest)
