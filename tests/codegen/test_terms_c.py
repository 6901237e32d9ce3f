"""The generated C of every term and input block is proved equal to the float32 reference; compiled, it has its bits."""

from collections.abc import Sequence

import numpy as np
import pytest

from fixtures.generated_models import hysteresis, relaxing
from fixtures.term_models import BLOCKS, FUNCTIONS, RESPONSES, TERMS, TOGETHER, compiled_with, hard_inputs, model_with
from fixtures.tools import library
from hysgen.checking import Host
from hysgen.checking.bits.functions import CallTrace, first_difference
from hysgen.checking.proof.translation import translation
from hysgen.codegen import generate
from hysgen.float32.reference.instance import Instance
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.drift import Drift
from hysgen.model.file import load_model
from hysgen.model.path import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.loop import Loop
from hysgen.model.path.modes import Modes

SAMPLES = 8000
"""Four times through what `hard_inputs` repeats every 2000 samples."""


def assert_equal_bits(
    terms: Sequence[Term], blocks: Sequence[InputBlock], function: str, samples: int, start_V: float = 30.0
) -> None:
    """Results and all states after every sample, of C and reference, from rest under start_V."""
    model, host = compiled_with(tuple(terms), tuple(blocks))
    y, u, y_next, *aux = hard_inputs(samples, host.channels, seed=20240607)
    inputs = {"predict": [y, u], "simulate": [u], "inverse": [y, y_next]}[function]
    layout = host.layout(f"{model.name}_t")
    struct = host.instance(2.0, start_V)
    bits = [column.view(np.uint32) for column in (*inputs, *aux)]
    out, trace = host.run(function, struct, bits, words=layout["bank[0].slope[0]"])

    lanes = Instance(model, np.full(1, 2.0, np.float32), np.full(1, start_V, np.float32))
    start = np.array([word[0] for word in lanes.words().values()])
    after = trace[:, 1:]
    assert start.size == after.shape[1]
    # By induction: equal at the start, and every step from a recorded state equal to the next one.
    before = np.vstack([start, after[:-1]])
    arguments, channels = bits[: len(inputs)], bits[len(inputs) :]
    assert first_difference(lanes, function, CallTrace(arguments, channels, before, out, after)) is None


@pytest.mark.parametrize("part", [*TERMS, *BLOCKS, *RESPONSES], ids=lambda part: f"{part.kind}")
def test_every_constant_of_a_part_has_a_meaning(part: Term | InputBlock) -> None:
    """The A2L file states them."""
    assert set(part.constants(2e-5)) <= set(part.quantities)


@pytest.mark.proof
@pytest.mark.parametrize(
    "parts",
    [
        *([part] for part in [*TERMS, *BLOCKS, *RESPONSES]),
        [Delay(0.0)],
        [Delay(2.0)],
        [Delay(0.7)],
        [BLOCKS[0], BLOCKS[2]],
        [Loop.examples(np.random.default_rng(4))[1]],
        [Delay(0.7), RESPONSES[4]],
        [hysteresis(0)],
        [hysteresis(3)],
        [hysteresis(0, 1)],
        [relaxing()],
        [*BLOCKS, relaxing(), *TOGETHER[1:]],
        [Modes((730.0,), (0.05,), (1.0,), 4e-4)],
        [Delay(0.7), Modes((50.0, 730.0), (0.01, 0.3), (0.2, 0.9), 4e-4)],
    ],
    ids=lambda parts: "+".join(part.kind for part in parts),
)
def test_each_part_alone_is_proved_equal_for_every_input(parts: list[Term | InputBlock]) -> None:
    library("bitwuzla")
    terms, blocks = ([part for part in parts if isinstance(part, kind)] for kind in (Term, InputBlock))
    model = model_with(terms, blocks)
    result = translation(model, generate(model), calls=FUNCTIONS)
    assert {proof.function: proof.holds for proof in result.functions} == dict.fromkeys(FUNCTIONS, True)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("blocks", [[*BLOCKS, *TOGETHER], [RESPONSES[4]]], ids=["together", "softening"])
@pytest.mark.slow
def test_compiled_c_has_the_bits_that_are_proved(blocks: list[InputBlock], function: str) -> None:
    assert_equal_bits(TERMS, blocks, function, SAMPLES)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.slow
def test_a_start_beyond_the_saturation_rests_at_its_level(function: str) -> None:
    assert_equal_bits(TERMS, [*BLOCKS, RESPONSES[1]], function, 200, start_V=110.0)
    model, host = compiled_with(tuple(TERMS), (*BLOCKS, RESPONSES[1]))
    struct, layout = host.instance(2.0, 110.0), host.layout(f"{model.name}_t")
    words = host.words_of(struct).view(np.float32)
    for path in ("inputs.v_V", "inputs.slew.last_V", "inputs.delay.ring[0]", "inputs.creep.high[0]"):
        assert words[layout[path]] == 95.0
    assert words[layout["u_V"]] == 110.0


def test_flushing_denormals_to_zero_changes_no_bit() -> None:
    terms = [Drift(1e-4, 0.05), Coupling(("t",), (-1.0,), (1.0,))]
    decaying = [Creep(0.01, (1e-4, 1e-3)), Modes((5000.0,), (0.5,), (0.3,), 4e-4)]
    model = model_with(terms, [*BLOCKS, *decaying])
    host = Host(model.name, generate(model))
    if not host.flushes:
        pytest.skip("this machine cannot be told to flush denormal numbers")
    # Without a floor, states that decay to zero are denormal after 87 time constants, 4000 samples of the slowest.
    u = np.where(np.arange(12_000) < 2000, 77.7, 0.0).astype(np.float32)
    tiny = np.where(np.arange(12_000) % 2 == 0, 1e-41, -3e-39).astype(np.float32)
    traces = []
    for flush in (False, True):
        struct = host.instance(0.0, 0.0)
        columns = [column.view(np.uint32) for column in (tiny, u, tiny)]
        out, trace = host.run("predict", struct, columns, words=len(host.layout(f"{model.name}_t")), flush=flush)
        traces.append((out, trace))
    assert np.array_equal(traces[0][0], traces[1][0])
    assert np.array_equal(traces[0][1], traces[1][1])


def test_channels_are_named_in_the_order_of_the_c() -> None:
    model = model_with(TERMS)
    header = generate(model)[f"{model.name}.h"]
    assert model.channels == ("temperature", "other drive [V]")
    assert " *     aux[0]  temperature\n *     aux[1]  other drive [V]\n" in header


def test_a_model_without_extensions_says_nothing_of_them() -> None:
    text = "".join(text for name, text in generate(load_model("appendix_a")).items() if name.endswith((".c", ".h")))
    for word in ("terms", "_inputs_", "_aux(", "CHANNELS", "PREVIEW", "accumulate", "cosine_sine"):
        assert word not in text
