"""The paper's experiments on the virtual bench: what has to hold whatever the stage's constants are."""

import pytest

from hysgen_lab.studies.paper.experiments import CASES, EXPERIMENTS, RepeatedExperiment, repeat, track_case
from hysgen_lab.studies.paper.learning import DISTURBANCES, agreement, lose_gain


@pytest.fixture(scope="module")
def section_4_2() -> RepeatedExperiment:
    return repeat(next(experiment for experiment in EXPERIMENTS if experiment.name == "4.2"))


@pytest.mark.slow
def test_one_step_error_of_the_papers_model_flatters(section_4_2: RepeatedExperiment) -> None:
    paper = section_4_2.scores["paper"]
    # The paper prints 0.0005 um; 0.002 um is what y(k+1) = y(k) scores. The free run is another matter.
    assert paper.one_step.e_rms_um < paper.persistence.e_rms_um
    assert paper.free_run.e_rms_um > 10 * paper.one_step.e_rms_um


@pytest.mark.slow
def test_memory_brings_the_free_run_down_to_the_one_step_error(section_4_2: RepeatedExperiment) -> None:
    before, after = section_4_2.started["refined"], section_4_2.started["memory"]
    assert after.e_rms_um < before.e_rms_um / 7
    assert after.e_rms_um < 2 * section_4_2.scores["memory"].noise.rms_um
    assert all(rival.e_rms_um > 5 * after.e_rms_um for _, rival in section_4_2.rivals)


@pytest.mark.slow
def test_inverse_feed_forward_tracks_better_than_proportional_and_memory_better_still() -> None:
    tracked = track_case(CASES[0])
    rms_nm = tracked.e_rms_nm
    # The paper finds a sixth of the proportional controller's largest error at 50 Hz.
    assert rms_nm["paper's inverse"] < rms_nm["proportional"] / 4
    assert rms_nm["with memory"] < rms_nm["paper's inverse"] / 2


@pytest.mark.slow
def test_the_learner_in_c_is_as_good_as_eq_10_in_float64() -> None:
    found = agreement(EXPERIMENTS[1])
    assert abs(found.excess) < 1e-3
    # Neither stands still: from data-sheet values, y(k+1) = y(k) is better than the model it starts from.
    assert found.learned_um < 0.0012


@pytest.mark.slow
def test_after_a_loss_of_gain_the_committed_model_is_soon_as_good_as_before() -> None:
    found = lose_gain("gain falls by 10 %")
    assert found.stale_um > 3.0 * found.before_um
    assert found.caught_up_s is not None
    assert found.caught_up_s <= 0.2
    assert found.committed > 10
    assert found.unsafe == 0


@pytest.mark.parametrize(
    "what",
    [pytest.param(what, marks=() if i < 2 else pytest.mark.proof) for i, what in enumerate(list(DISTURBANCES)[1:])],
)
@pytest.mark.slow
def test_nothing_is_committed_from_records_that_teach_nonsense(what: str) -> None:
    found = lose_gain(what)
    assert (found.committed, found.unsafe) == (0, 0)
    assert found.free_run_um[-1] == found.stale_um
