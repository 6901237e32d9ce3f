"""The generated learner equals its float32 reference in every bit of its state, whatever it is made to swallow."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from fixtures.learner_bench import Floats32, Pair, corrupted, sized
from fixtures.proof_models import texts
from hysgen.checking import Host
from hysgen.errors import HysgenError
from hysgen.model.structs import Member


def losing(pair: Pair) -> Iterator[tuple[Floats32, Floats32]]:
    """Samples between which bits are flipped so that the shadow is lost: wild, beyond its limit, far off for long."""
    y, u = corrupted(1200)
    for k, flipped in enumerate(
        ({}, {"d": 1e30}, {"theta": 2.0 * float(pair.lane.numbers.limit_um)}, {"error": 1e9, "age": 1_000_000})
    ):
        for word, value in flipped.items():
            getattr(pair.lane, word)[0] = value
            if word in ("theta", "d"):
                getattr(pair.learner, word)[0] = value
            else:
                setattr(pair.learner, word, value)
        yield y[150 * k : 150 * (k + 1)], u[150 * k : 150 * (k + 1)]


@pytest.mark.slow
def test_a_restart_is_whole_in_the_call_that_loses_the_shadow() -> None:
    """Bits after every call; parameters, age and U of a lost shadow are those of the prior before the call returns."""
    pair = Pair(sized(18))
    names = list(pair.lane.words())
    row = {name: names.index(name) for name in ("age", "restarts")}
    theta, reference, factors = (
        [k for k, name in enumerate(names) if name.startswith(f"{group}[")] for group in ("theta", "reference", "u")
    )
    restarts = 0
    for y, u in losing(pair):
        for k, got in enumerate(pair.run(y, u)):
            pair.lane.learn(y[k : k + 1], u[k : k + 1])
            wrong = np.flatnonzero(got != pair.expected())
            assert not wrong.size, f"sample {k}: {names[wrong[0]]}"
            if got[row["restarts"]] > restarts:
                restarts = int(got[row["restarts"]])
                assert got[row["age"]] == 0
                assert list(got[theta]) == list(got[reference])
                assert not got[factors].any()
    assert restarts == 3


@pytest.mark.slow
def test_a_learner_starts_with_every_state_of_the_model_and_of_what_the_input_passes() -> None:
    """Copied number by number, from what the terms and blocks declare."""
    name = "everything"
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
    # Last voltage, what the inverse asked and where limits led it (2, and 2 of a mode), slew, delay (ring of 4, index,
    # v), hysteresis (6 plays, 7 sums, 2 x 2 of Duhem states, turn, last input and output), 2 x 4 creep, 4 modes,
    # 2 periodic, 2 coupling, 2 drift.
    assert len(states) == 1 + 4 + 1 + 6 + 20 + 8 + 4 + 2 + 2 + 2
    assert np.count_nonzero([a for a, _ in copied]) > 20


@pytest.mark.parametrize(("kind", "sizes"), [("double", ()), ("float *", ()), ("float", (2, 2, 2))])
def test_a_state_that_cannot_be_copied_number_by_number_is_refused(kind: Any, sizes: tuple[int, ...]) -> None:
    with pytest.raises(HysgenError, match="is a float or a uint32_t, alone or with up to two sizes"):
        Member("x", kind, "state", sizes)
