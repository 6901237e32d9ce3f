"""The generated learner equals its float32 reference in every bit of its state, whatever it is made to swallow."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

from fixtures.generated_models import everything, smooth
from fixtures.learner_bench import Floats32, Pair, corrupted, lagging, sized, texts_of
from fixtures.proof_models import texts
from fixtures.tools import need
from hysgen.checking.bits.builds import compiled
from hysgen.checking.bits.comparison import Task, compare_task
from hysgen.checking.bits.functions import LEARNER
from hysgen.checking.bits.inputs import STYLES
from hysgen.checking.host import Host
from hysgen.errors import HysgenError
from hysgen.machine.native import Toolchain
from hysgen.model.file import load_model
from hysgen.model.learner_settings import LEARNED, LearnerSettings
from hysgen.model.model import Model
from hysgen.model.structs import Member
from hysgen.model.terms.memory import Memory

SUBSETS = [LEARNED["bias"], LEARNED["terms"], LEARNED["rules"], ("gain",), ("offset",), ("slope", "offset", "terms")]


@pytest.mark.parametrize("size", [6, 18, 24, 40])
@pytest.mark.slow
def test_generated_learner_equals_reference_bit_for_bit_sample_by_sample(size: int) -> None:
    """Every compared word after every sample of one chain: the reference really runs it in a row."""
    assert Pair(sized(size, settle=256)).first_difference(*corrupted(600)) is None


@pytest.mark.parametrize("learned", SUBSETS, ids="+".join)
@pytest.mark.slow
def test_a_subset_of_the_parameters_learns_bit_for_bit(learned: tuple[str, ...]) -> None:
    model = dataclasses.replace(
        smooth(5, (Memory.uniform(3, 60.0),)), learner=LearnerSettings(learned=learned, settle=128)
    )
    assert Pair(model).first_difference(*corrupted(600)) is None


@pytest.mark.parametrize(("size", "calls"), [(6, 2), (18, 6)])
@pytest.mark.slow
def test_a_spread_update_equals_its_reference_after_every_call(size: int, calls: int) -> None:
    assert Pair(sized(size, calls_per_update=calls, settle=64)).first_difference(*corrupted(600)) is None


@functools.lru_cache(maxsize=4)
def spread_texts(size: int, calls: int) -> Mapping[str, str]:
    return texts_of(sized(size, calls_per_update=calls))


def losing(pair: Pair) -> Iterator[tuple[Floats32, Floats32]]:
    """Samples between which bits are flipped so that the shadow is lost: beyond its limit, wild, far off for long."""
    y, u = corrupted(1200)
    k = 0
    schedule, limit_um = pair.lane.numbers.schedule, float(pair.lane.numbers.limit_um)
    for phase, flipped in (
        (schedule.calls, {"theta": 2.0 * limit_um}),
        (0, {"d": 1e30}),
        (0, {"error": 1e9, "age": 1_000_000}),
    ):
        yield y[k : k + 150], u[k : k + 150]
        k += 150
        while pair.lane.phase[0] != phase:
            yield y[k : k + 1], u[k : k + 1]
            k += 1
        for word, value in flipped.items():
            getattr(pair.lane, word)[0] = value
            if word in ("theta", "d"):
                getattr(pair.learner, word)[0] = value
            else:
                setattr(pair.learner, word, value)
    yield y[k : k + 150], u[k : k + 150]


@pytest.mark.parametrize(("size", "calls"), [(6, 12), (18, 2), (18, 8), (40, 8)])
@pytest.mark.slow
def test_a_restart_spread_over_calls_is_whole_for_commit_at_once_and_for_the_next_update(size: int, calls: int) -> None:
    """Bits after every call; the shadow that commit reads is there in the call that loses it, U before what follows."""
    pair = Pair(sized(size, calls_per_update=calls), spread_texts(size, calls))
    schedule, names = pair.lane.numbers.schedule, list(pair.lane.words())
    row = {name: names.index(name) for name in ("phase", "age", "restarts")}
    theta, reference, factors = (
        [k for k, name in enumerate(names) if name.startswith(f"{group}[")] for group in ("theta", "reference", "u")
    )
    lost_in: set[int] = set()
    for y, u in losing(pair):
        before = pair.expected()
        for k, got in enumerate(pair.run(y, u)):
            pair.lane.learn(y[k : k + 1], u[k : k + 1])
            wrong = np.flatnonzero(got != pair.expected())
            assert not wrong.size, f"sample {k}: {names[wrong[0]]}"
            if got[row["restarts"]] > before[row["restarts"]]:
                lost_in.add(int(before[row["phase"]]))
                assert got[row["phase"]] == schedule.clearing
                assert got[row["age"]] == 0
                assert list(got[theta]) == list(got[reference])
            elif before[row["phase"]] == schedule.phases:
                assert got[row["phase"]] == 0
                assert set(got[factors].view(np.float32)) <= {0.0, 1.0}
            before = got
    # Where the sample is taken, at the end of the first half of an update (of two calls, the same), and at its end.
    assert lost_in == {0, schedule.calls} | ({len(schedule.project) - 1} if calls > 2 else set())


@pytest.mark.parametrize(
    ("size", "left_out"), [(40, "    smooth_10_clear_column(self, 39u);\n}"), (18, "self->u[152] = 0.0f;\n}")]
)
@pytest.mark.slow
def test_a_restart_that_leaves_out_a_column_is_found(size: int, left_out: str) -> None:
    model = sized(size, calls_per_update=8)
    texts = dict(spread_texts(size, 8))
    file = f"{model.name}.c"
    assert texts[file].count(left_out) == 1
    texts[file] = texts[file].replace(left_out, "}")
    pair = Pair(model, texts)
    assert "u[" in str(next(filter(None, (pair.first_difference(*piece) for piece in losing(pair))), None))


@pytest.mark.slow
def test_a_learner_starts_with_every_state_of_the_model_and_of_what_the_input_passes() -> None:
    """Copied number by number, from what the terms and blocks declare."""
    name = "everything_spread"
    host = Host(name, texts(name))
    instance, learner = host.instance(2.0, 20.0), host.struct(f"{name}_learner_t")
    rng = np.random.default_rng(3)
    columns = [
        rng.uniform(low, high, 500).astype(np.float32).view(np.uint32) for low, high in [(1, 3), (0, 60), (20, 25)]
    ]
    host.run("predict", instance, columns)
    host.call("learn_init", learner, instance)
    mine, models = host.layout(f"{name}_learner_t"), host.layout(f"{name}_t")
    states = [path for path in models if path.startswith(("terms.", "inputs."))]
    model_words, learner_words = host.words_of(instance), host.words_of(learner)
    copied = [(int(model_words[models[path]]), int(learner_words[mine[path]])) for path in states]
    assert [a for a, _ in copied] == [b for _, b in copied]
    # 4 plays, 2 x 3 creep, 4 resonance, 2 periodic, 2 coupling, 2 drift; last input, slew, ring of 4 and its index.
    assert len(states) == 4 + 6 + 4 + 2 + 2 + 2 + 1 + 1 + 4 + 1
    assert np.count_nonzero([a for a, _ in copied]) > 20


@pytest.mark.parametrize(("kind", "sizes"), [("double", ()), ("float *", ()), ("float", (2, 2, 2))])
def test_a_state_that_cannot_be_copied_number_by_number_is_refused(kind: Any, sizes: tuple[int, ...]) -> None:
    with pytest.raises(HysgenError, match="is a float or a uint32_t, alone or with up to two sizes"):
        Member("x", kind, "state", sizes)


@pytest.mark.slow
def test_terms_blocks_and_drift_of_the_learner_are_its_own_and_equal() -> None:
    model = dataclasses.replace(everything(), learner=LearnerSettings(learned=("gain", "offset", "terms")))
    assert Pair(model).first_difference(*corrupted(500)) is None


@pytest.mark.parametrize("toolchain", [Toolchain("gcc", ("-O3",)), Toolchain("clang", ("-O2",))], ids=str)
@pytest.mark.parametrize("size", [6, 18, 24, 40])
@pytest.mark.slow
def test_long_chains_are_equal_by_induction_with_and_without_flush_to_zero(size: int, toolchain: Toolchain) -> None:
    need(toolchain.command)
    model = sized(size, settle=512)
    builds, _ = compiled(model.name, texts_of(model), [toolchain])
    for style in STYLES:
        _, wrong = compare_task(model, builds, Task(LEARNER, "learn", style), 2000, 7, lambda samples: None)
        assert not wrong, wrong[0]


@pytest.mark.parametrize(
    ("intact", "planted"),
    [
        ("self->theta_low[3] = left3;", "self->theta_low[3] = 0.0f;"),
        ("self->turn = (j + 1u <", "self->turn = (j + 2u <"),
        ("f5 = f5 + m2_5;", "f5 = m2_5 + f5 * 1.0000001f;"),
        ("const uint32_t usable = 1u ^ (y_lost | implausible);", "const uint32_t usable = 1u ^ y_lost;"),
    ],
)
@pytest.mark.slow
def test_a_planted_fault_is_found(intact: str, planted: str) -> None:
    model = dataclasses.replace(load_model("appendix_a"), learner=LearnerSettings())
    texts = texts_of(model)
    assert intact in texts["appendix_a.c"]
    texts["appendix_a.c"] = texts["appendix_a.c"].replace(intact, planted)
    assert Pair(model, texts).first_difference(*corrupted(600)) is not None


@pytest.mark.parametrize("calls", [2, 6])
@pytest.mark.slow
def test_an_update_spread_over_calls_gives_the_bits_of_one_at_once(calls: int) -> None:
    """The spread learner uses the samples c i and c i + 1; the other one is shown just these, cut apart by NaN."""
    y, u = lagging(600 * calls + 2)
    spread = Pair(spread_model(calls))
    spread.run(y[: 600 * calls + 1], u[: 600 * calls + 1])
    first = calls * np.arange(600)
    cut_y = np.stack([np.full(600, np.nan, np.float32), y[first], y[first + 1]], axis=1).ravel()
    cut_u = np.stack([u[first], u[first], u[first + 1]], axis=1).ravel()
    once = Pair(spread_model(1))
    once.run(cut_y, cut_u)
    assert spread.learner.updates == once.learner.updates > 500
    for group in ("d", "u", "theta", "theta_low"):
        assert list(getattr(spread.learner, group)) == list(getattr(once.learner, group)), group


def spread_model(calls: int) -> Model:
    """Nothing is gated, for a sample that is not learnt from would end its update early and shift what follows."""
    return sized(18, calls_per_update=calls, rest_V=0.0, dead_zone_um=0.0, outlier_ratio=1e6)
