"""The self-test of the generated C: it passes here, and each planted fault of learner and commit fails it."""

import functools
import re
from collections.abc import Mapping

import pytest

from fixtures.proof_models import model
from hysgen.certify.certificates import certify
from hysgen.checking import Host
from hysgen.codegen import Options, generate
from hysgen.codegen.selftest import hashed, learning
from hysgen.float32.struct_words import Commit
from hysgen_lab.firmware.reference_models import firmware_models

SHIPPED = {each.name: each for each in firmware_models()}
PLANTED = {
    "an element of U is read for another": (
        r"u\[i\] = self->u\[(\w+)\(i, j\)\];",
        r"u[i] = self->u[(j == 2u) ? 1u : \1(i, j)];",
    ),
    "the gain's refusal is taken out": (r"return (\w+)_REFUSED_GAIN;", r"return \1_BUSY;"),
    "the slope's refusal is taken out": (r"\(steep != 0u\)", "(steep > 1000u)"),
    "the limit's refusal is taken out": (r"return (\w+)_REFUSED_LIMIT;", r"return \1_BUSY;"),
    "the age's refusal is taken out": (r"return (\w+)_REFUSED_YOUNG;", r"return \1_BUSY;"),
    "a commit keeps the old reference": (r"learner->reference\[(\w+)\] = ", r"learner->theta_low[\1] = "),
    "a sample is not counted": (r"&self->updates, ", "&self->changes, "),
}


@functools.cache
def texts(name: str) -> Mapping[str, str]:
    return generate(SHIPPED[name])


@pytest.mark.parametrize("fault", PLANTED)
@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.slow
def test_every_planted_fault_of_learner_and_commit_is_a_mismatch(name: str, fault: str) -> None:
    file, (old, new) = f"{name}.c", PLANTED[fault]
    source, count = re.subn(old, new, texts(name)[file], count=1)
    assert count == 1
    assert Host(name, {**texts(name), file: source}).call("selftest") > 0


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shadows_get_every_answer_of_commit(name: str) -> None:
    found = learning(SHIPPED[name], certify(SHIPPED[name]))
    assert found is not None
    assert {case.answer for case in found.cases} == set(Commit) - {Commit.BUSY, Commit.TRYING}
    assert Host(name, texts(name)).call("selftest") == 0


@pytest.mark.slow
def test_a_learner_with_auxiliary_channels_passes() -> None:
    everything = model("everything")
    made = generate(everything, Options(clock_Hz=2e9))
    assert "learn_aux" in made[f"{everything.name}_selftest.c"]
    assert Host(everything.name, made).call("selftest") == 0


def test_one_wrong_bit_of_one_word_changes_the_hash() -> None:
    words = [0, 1, 0xFFFFFFFF, 0x80000000]
    expected = hashed(words)
    for place in range(len(words)):
        for bit in range(32):
            assert hashed([word ^ (1 << bit if i == place else 0) for i, word in enumerate(words)]) != expected
