"""Commit makes no shadow active whose certificates do not hold, in the bits of its reference, and whoever reads the
parameters meanwhile sees the old ones or the new ones."""

import dataclasses
import functools
import importlib
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.commit_border import acceptance_boundary, answers, directions
from fixtures.generated_models import smooth
from fixtures.learner_bench import START_UM, START_V, sized, texts_of
from hysgen.certify.certificates import certify
from hysgen.checking import Host, compiled
from hysgen.checking.bits.comparison import committer_of, compare_commit
from hysgen.float32.learner_numbers import learned_model
from hysgen.float32.reference.commit import Committer
from hysgen.float32.struct_words import Commit
from hysgen.machine.native import Toolchain
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.file import load_model
from hysgen.model.learner_settings import LEARNED, LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path.creep import Creep

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
commits = importlib.import_module("commits")

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

CC = Toolchain("cc", ("-O2",))
"""What this machine has: gcc or clang."""


def paper(learned: str = "rules") -> Model:
    """Appendix A with a learner."""
    settings = LearnerSettings(learned=LEARNED[learned])
    return dataclasses.replace(load_model("appendix_a"), name=f"paper_{learned}", learner=settings)


def remembering() -> Model:
    """Four rules behind six plays and a creep state, with a disturbance whose weights are not learned."""
    base = smooth(4, 6)
    return dataclasses.replace(
        base,
        name="remembering",
        blocks=(*base.blocks, Creep(0.01, (0.01,))),
        terms=(Periodic((50.0,)),),
        weights=np.array([1e-3, 2e-3]),
        learner=LearnerSettings(),
    )


@pytest.mark.slow
def test_a_planted_fault_is_found() -> None:
    model, intact = sized(6), "bank->gain[l] = learner->"
    texts = texts_of(model)
    assert intact in texts["smooth_2.c"], f"the fault has nothing to bite on: {intact}"
    texts["smooth_2.c"] = texts["smooth_2.c"].replace(intact, "bank->gain[l] = (l == 1u) ? 0.5f : learner->")
    builds, _ = compiled(model.name, texts, [CC])
    assert compare_commit(model, builds, seed=1)[1]


def certified(committer: Committer, model: Model, theta: Floats32) -> bool:
    """Whether gain, contraction and inverse of a shadow (n,) are certified in float64, by enclosure over the range."""
    learner = committer.learner
    found = certify(learned_model(model, learner.model_numbers, learner.numbers, theta.astype(np.float64)))
    return found.gain_holds and found.contraction_holds and found.inverse_holds


def farthest_are_certified(model: Model, spoil: Callable[[Committer], None] = lambda committer: None) -> bool:
    """Whether the last shadow that commit lets pass in each of many directions is certified in float64.

    spoil: takes a protection out of the committer.
    """
    committer = committer_of(model)
    spoil(committer)
    last, first = acceptance_boundary(committer, directions(committer, np.random.default_rng(11)))
    accepted = answers(committer, last)
    assert (accepted == Commit.COMMITTED).all()
    assert (answers(committer, first) != Commit.COMMITTED).all()
    return all(certified(committer, model, last[:, lane]) for lane in range(last.shape[1]))


@pytest.mark.parametrize("model", [paper(), sized(24), sized(36), remembering()], ids=lambda model: model.name)
@pytest.mark.slow
def test_the_farthest_shadow_that_is_accepted_in_any_direction_is_certified(model: Model) -> None:
    """Bisection to where commit begins to refuse; float64 enclosures judge what it let pass just before."""
    assert farthest_are_certified(model)


@pytest.mark.parametrize("protection", [{"gain_floor": -np.inf}, {"slope_limit": 2.0}], ids=["gain", "slope"])
def test_without_a_protection_an_uncertified_shadow_would_pass(protection: dict[str, float]) -> None:
    """What the test above rests on: it can tell."""

    def spoil(committer: Committer) -> None:
        numbers = {name: np.float32(value) for name, value in protection.items()}
        committer.numbers = dataclasses.replace(committer.numbers, **numbers)

    assert not farthest_are_certified(paper(), spoil)


@pytest.mark.parametrize("points_per_call", [1, 7, 64])
def test_the_answer_does_not_depend_on_how_the_check_is_spread_over_calls(points_per_call: int) -> None:
    committer = committer_of(sized(18, points_per_call=points_per_call))
    shadows = np.concatenate(
        acceptance_boundary(committer, directions(committer, np.random.default_rng(5)))[:2], axis=1
    )
    shadows = shadows[:, :: shadows.shape[1] // committer.learner.theta.shape[1]]
    expected = answers(committer_of(sized(18)), shadows)
    assert len(set(expected.tolist())) >= 3
    committer.learner.theta = shadows
    told, calls = np.zeros_like(expected), 0
    while (told == Commit.BUSY).any():
        told, calls = np.where(told == Commit.BUSY, committer.commit(), told), calls + 1
    np.testing.assert_array_equal(told, expected)
    assert calls == -(-committer.numbers.points // points_per_call) + 4


@functools.cache
def compiled_once() -> Host:
    return Host("remembering", texts_of(remembering()), CC)


class Planted:
    """A compiled learner into which shadows are planted."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.instance = self.host.instance(float(START_UM), float(START_V))
        self.learner = self.host.struct(f"{host.name}_learner_t")
        self.host.call("learn_init", self.learner, self.instance)
        self.learner.age = LearnerSettings().mature
        self.own = np.array(list(self.learner.theta))

    def answer(self, theta: Floats) -> Commit:
        """What commit says to theta (n,) in the end."""
        self.learner.theta[0 : theta.size] = theta.tolist()
        return next(Commit(a) for a in iter(lambda: self.host.commit(self.instance, self.learner), -1) if a)

    @property
    def active(self) -> tuple[int, bytes]:
        """Which bank is in use, and what is in it."""
        words, layout = self.host.words_of(self.instance), self.host.layout(f"{self.host.name}_t")
        number = int(self.instance.active)
        return number, words[[at for path, at in layout.items() if path.startswith(f"bank[{number}]")]].tobytes()


REFUSALS: dict[str, tuple[int, float, Commit]] = {
    "gain of a rule turned round": (1, -1.0, Commit.REFUSED_GAIN),
    "slope above one": (6, 1.5, Commit.REFUSED_SLOPE),
    "offset that tilts the rules": (8, -30.0, Commit.REFUSED_SLOPE),
    "not a number": (5, np.nan, Commit.REFUSED_LIMIT),
    "infinite": (5, -np.inf, Commit.REFUSED_LIMIT),
    "huge": (5, 1e30, Commit.REFUSED_LIMIT),
}


@pytest.mark.parametrize("reason", REFUSALS)
@pytest.mark.slow
def test_a_planted_shadow_is_refused_with_the_reason_and_what_is_active_stays(reason: str) -> None:
    place, factor, expected = REFUSALS[reason]
    planted = Planted(compiled_once())
    theta = planted.own.copy()
    theta[place] *= factor
    before = planted.active
    assert planted.answer(theta) == expected
    assert planted.active == before
    np.testing.assert_array_equal(np.float32(theta), np.float32(list(planted.learner.theta)))
    assert planted.answer(planted.own) == Commit.COMMITTED
    assert planted.active[0] != before[0]


@pytest.mark.slow
def test_a_shadow_that_has_just_restarted_is_too_young() -> None:
    planted = Planted(compiled_once())
    planted.learner.age = LearnerSettings().mature - 1
    assert planted.answer(planted.own) == Commit.REFUSED_YOUNG


@pytest.mark.slow
@pytest.mark.parametrize("forgetting", commits.FORGETTING)
def test_no_commit_makes_the_model_worse(forgetting: float) -> None:
    """Over excitations, noise and stages: no step ahead; in free run by the 0.2 % that a trial of 2048 samples misses.

    Without the trial, 0.99 is worse by a third (`test_a_shadow_that_would_make_the_model_worse_...`).
    """
    model = sized(18, forgetting=forgetting)
    host = Host("smooth_6", texts_of(model), CC)
    rows = [row for stage in commits.STAGES.values() for row in commits.over(host, model, stage)]
    made = np.array([ratios for answer, *ratios in rows if answer == Commit.COMMITTED])
    assert len(made) >= 8
    assert (made.max(axis=0) < (1.0, 1.003)).all()


@pytest.mark.parametrize("tried", [True, False])
def test_a_shadow_that_would_make_the_model_worse_is_refused_after_its_trial(tried: bool) -> None:
    """Of a stage with a play, learnt with a memory of 100 samples; without the trial it is committed, and is worse."""
    model = sized(18, forgetting=0.99)
    texts = texts_of(model)
    if not tried:
        trial = "? (uint32_t)SMOOTH_6_COMMIT_TRIAL : 0u"
        assert trial in texts["smooth_6.c"]
        texts["smooth_6.c"] = texts["smooth_6.c"].replace(trial, "? 0u : 0u")
    host, u_V = Host("smooth_6", texts, CC), 50.0 + 60.0 * commits.EXCITATIONS["beat"](commits.TIMES_S)
    play, weaker = (commits.measured_um(model, u_V, stage, 0.0) for stage in ((1.0, 8.0), (0.9, 0.0)))
    answer, one_step, free_run = commits.committed(host, model, play, u_V)
    assert (answer, one_step > 1.05, free_run > 1.05) == (
        (Commit.REFUSED_WORSE, False, False) if tried else (Commit.COMMITTED, True, True)
    )
    answer, one_step, free_run = commits.committed(host, model, weaker, u_V)
    assert answer == Commit.COMMITTED
    assert max(one_step, free_run) < 0.9


SEEN = "uint32_t smooth_2_seen(uint32_t i);"
INTERRUPT = """
static uint32_t smooth_2_seen_bits[4096];
static uint32_t smooth_2_seen_count;

uint32_t smooth_2_seen(uint32_t i)
{
    return (i < smooth_2_seen_count) ? smooth_2_seen_bits[i] : 0u;
}

static void smooth_2_interrupt(const smooth_2_t *self)
{
    smooth_2_t copy = *self;
    union { float value; uint32_t bits; } y;

    y.value = smooth_2_predict(&copy, 3.0f, 40.0f);
    smooth_2_seen_bits[smooth_2_seen_count++ % 4096u] = y.bits;
}
"""


def interrupted(texts: dict[str, str]) -> dict[str, str]:
    """The texts with a prediction after every statement of what writes the parameters and makes them active."""
    start = texts["smooth_2.c"].index("static void smooth_2_write(")
    body = re.sub(r";\n", "; smooth_2_interrupt(self);\n", texts["smooth_2.c"][start:])
    head = texts["smooth_2.h"].replace("void smooth_2_init(", f"{SEEN}\nvoid smooth_2_init(", 1)
    return texts | {"smooth_2.c": texts["smooth_2.c"][:start] + INTERRUPT + body, "smooth_2.h": head}


def predictions_seen(texts: dict[str, str]) -> list[int]:
    """Bits of the predictions of an interrupt that comes between any two statements while a shadow is committed."""
    planted = Planted(Host("smooth_2", interrupted(texts), CC, declarations=SEEN))
    assert planted.answer(planted.own * np.where(np.arange(6) % 3 == 1, 1.2, 1.0)) == Commit.COMMITTED
    seen = [int(planted.host.call("seen", i)) for i in range(4096)]
    return [bits for bits in seen if bits]


def test_an_interrupt_between_any_two_statements_sees_the_old_parameters_or_the_new_ones() -> None:
    seen = predictions_seen(texts_of(sized(6)))
    assert len(seen) > 100
    assert len(set(seen)) == 2
    assert seen == sorted(seen, key=lambda bits: bits != seen[0]), "and never the old ones again"


def test_writing_to_the_bank_in_use_would_be_seen() -> None:
    texts = texts_of(sized(6))
    planted = texts["smooth_2.c"].replace("bank[1u - self->active]", "bank[self->active]")
    assert planted != texts["smooth_2.c"]
    assert len(set(predictions_seen(texts | {"smooth_2.c": planted}))) > 2
