"""The box of every float of the state: each has one, it encloses what running C makes of the float, and Eva demands it.

Eva shows that the box is never left. Running the C shows the other way round that the box is of that float: a value
outside would be a proof of something else.
"""

import dataclasses
import functools
from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from fixtures.generated_models import diagnosed
from fixtures.proof_models import model, texts
from fixtures.term_models import BLOCKS, FUNCTIONS, RESPONSES, TERMS, TOGETHER, compiled_with, hard_inputs, model_with
from fixtures.tools import need
from hysgen.checking import Host
from hysgen.checking.proof.eva.boxes import WILD, learner_box, parts_box, state_box
from hysgen.checking.proof.eva.calls import learn_step, prove_call, step
from hysgen.codegen.structs import Interface, interface_of
from hysgen.errors import ModelError
from hysgen.model import disturbances
from hysgen.model import path as inputs
from hysgen.model.disturbances import Term, TermBox
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.intervals import Interval
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.path.base import BlockBox
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation

SAMPLES = 8000
ALONE = [[block] for block in (*BLOCKS, *TOGETHER)]
CHAINS: list[list[InputBlock]] = [
    [*BLOCKS, *TOGETHER],
    *([block] for block in RESPONSES if block not in TOGETHER),
    [Delay(0.0)],
    [Delay(0.7)],
    list(diagnosed().blocks),
]


@functools.lru_cache(maxsize=4)
def host_of(name: str) -> Host:
    return Host(name, texts(name))


def floats_of(known: Interface, struct: str) -> list[str]:
    return [word.path for word in known.struct(struct).words() if word.type == "float"]


def outside(ran: Mapping[str, np.ndarray], box: Mapping[str, Interval]) -> list[str]:
    """Floats that were not finite or not in their box, by C path."""
    return [
        path
        for path, values in ran.items()
        if not ((values >= np.float32(box[path].low)) & (values <= np.float32(box[path].high))).all()
    ]


def of_instance(host: Host, function: str, seed: int) -> dict[str, np.ndarray]:
    """Every float outside the banks after every sample of hard inputs, by C path."""
    struct = f"{host.name}_t"
    y, u, y_next, *aux = hard_inputs(SAMPLES, host.channels, seed)
    columns = {"predict": [y, u], "simulate": [u], "inverse": [y, y_next]}[function]
    layout = host.layout(struct)
    bits = [column.view(np.uint32) for column in (*columns, *aux)]
    instance = host.instance(2.0, 30.0)
    _, trace = host.run(function, instance, bits, words=layout["bank[0].slope[0]"])
    values = np.ascontiguousarray(trace).view(np.float32)
    return {path: values[:, layout[path]] for path in floats_of(host.interface, struct) if not path.startswith("bank[")}


def assert_in_box(terms: Sequence[Term], blocks: Sequence[InputBlock], function: str) -> None:
    found, host = compiled_with(tuple(terms), tuple(blocks))
    assert outside(of_instance(host, function, seed=5), state_box(found)) == []


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("term", TERMS, ids=lambda term: f"{term.kind}{term.size}")
@pytest.mark.slow
def test_the_state_of_each_term_stays_in_its_box(term: Term, function: str) -> None:
    assert_in_box([term], (), function)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(
    "blocks",
    [*CHAINS, *(pytest.param(blocks, marks=pytest.mark.proof) for blocks in ALONE)],
    ids=lambda blocks: "+".join(block.kind for block in blocks),
)
@pytest.mark.slow
def test_the_state_of_each_block_and_of_a_term_behind_it_stays_in_its_box(
    blocks: list[InputBlock], function: str
) -> None:
    assert_in_box([TERMS[0]], blocks, function)


def test_every_kind_that_is_installed_is_among_them() -> None:
    assert {term.kind for term in TERMS} == set(disturbances.kinds())
    assert {block.kind for chain in CHAINS for block in chain} == set(inputs.kinds())


def test_the_regressors_stay_below_what_their_box_says() -> None:
    """Of the float32 mirrors, with channels and innovations far beyond what a stage shows."""
    rng = np.random.default_rng(6)
    for term in TERMS:
        mirror, seen = term.mirror(50, 2e-5), np.zeros(term.size)
        for _ in range(1000):
            mirror.listen({name: rng.normal(0.0, 1e3, 50).astype(np.float32) for name in term.channels})
            mirror.correct(rng.normal(0.0, 100.0, 50).astype(np.float32))
            largest = [float(np.abs(phi).max()) for phi in mirror.regressors()]
            seen = np.maximum(seen, largest)
            mirror.advance()
        bounds = np.array(disturbances.box_of(term, 2e-5).regressors)
        assert (seen <= bounds).all(), term.kind
        # Noise does not drive modes to their bound; tests/model/test_terms.py does.
        assert term.kind == "drives" or (seen > 0.9 * bounds).all(), term.kind


@pytest.mark.parametrize("name", ["diagnosed", "extended", "everything"])
@pytest.mark.slow
def test_every_float_of_a_learner_stays_in_its_box(name: str) -> None:
    """What is not WILD, after every sample that is learnt from or refused."""
    host, struct = host_of(name), f"{name}_learner_t"
    learner, layout = host.struct(struct), host.layout(struct)
    host.call("learn_init", learner, host.instance(2.0, 30.0))
    y, u, _, *aux = hard_inputs(SAMPLES, host.channels, seed=7)
    traces = []
    for first in range(0, SAMPLES, SAMPLES if not aux else 40):
        if aux:
            host.call("learn_aux", learner, [float(column[first]) for column in aux])
        pieces = [column[first : first + (40 if aux else SAMPLES)].view(np.uint32) for column in (y, u)]
        traces.append(host.run("learn", learner, pieces, words=len(layout))[1])
    values = np.vstack(traces).view(np.float32)
    paths = [p for p in floats_of(host.interface, struct) if p.split("[")[0] not in WILD]
    ran = {p: values[:, layout[p]] for p in paths if not p.startswith(("candidate.", "base."))}
    box = learner_box(model(name)).floats
    assert outside(ran, box) == []
    parts = {p for p in parts_box(model(name)).floats if not p.startswith("loop.")}
    assert {p for p in ran if p.startswith(("terms.", "inputs."))} == parts
    moved = [p for p, seen in ran.items() if np.ptp(seen) > 0]
    for path in moved:
        assert outside(ran, {**box, path: halved(ran[path])}) == [path]


def halved(seen: np.ndarray) -> Interval:
    """The lower half of where a float was seen: a box that is too small."""
    low, high = float(np.nanmin(seen)), float(np.nanmax(seen))
    return Interval(low, 0.5 * (low + high))


@pytest.mark.parametrize("name", ["extended", "diagnosed", "everything"])
@pytest.mark.slow
def test_a_box_that_is_too_small_is_left(name: str) -> None:
    ran = of_instance(host_of(name), "predict", seed=8)
    box = state_box(model(name))
    assert set(ran) == set(box)
    assert outside(ran, box) == []
    moved = [path for path, seen in ran.items() if np.ptp(seen) > 0]
    assert len(moved) > 0.7 * len(ran)
    for path in moved:
        assert outside(ran, {**box, path: halved(ran[path])}) == [path]


class Halved(Creep):
    """A box of the first slow state only."""

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        whole = super().box(u_V, Ts_s)
        return dataclasses.replace(whole, floats={path: whole.floats[path] for path in ("high[0]", "low[0]")})


class Small(Creep):
    """A box of the third slow state that is too small."""

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        whole = super().box(u_V, Ts_s)
        return dataclasses.replace(whole, floats={**whole.floats, "high[2]": u_V, "low[2]": Interval(0.0, 0.0)})


def with_creep(kind: type[Creep], name: str) -> Model:
    """A model with a creep block of another class, whose C is the same."""
    found = model(name)
    blocks = [kind(block.amount, block.tau_s) if isinstance(block, Creep) else block for block in found.blocks]
    altered = dataclasses.replace(found)
    object.__setattr__(altered, "blocks", tuple(blocks))
    return altered


def test_a_float_without_a_box_is_refused() -> None:
    altered, generated = with_creep(Halved, "diagnosed"), texts("diagnosed")
    with pytest.raises(ModelError, match=r"diagnosed_t: inputs\.creep\.high\[1\]: a float without a box"):
        step(altered, generated, "predict", "finite")
    with pytest.raises(ModelError, match=r"diagnosed_learner_t: inputs\.creep\.high\[1\]: a float without a box"):
        learn_step(altered, generated, "learn")


@pytest.mark.parametrize("name", ["extended", "diagnosed", "everything"])
@pytest.mark.slow
def test_every_float_of_the_state_is_assumed_in_a_box_and_demanded_afterwards(name: str) -> None:
    sources, _ = step(model(name), texts(name), "predict", "finite")
    for path in floats_of(interface_of(name, texts(name)), f"{name}_t"):
        if not path.startswith("bank["):
            assert f"self.{path} = Frama_C_float_interval(" in sources["step.c"], path
            assert rf"\is_finite(self.{path}) && " in sources["step.c"], path


@pytest.mark.parametrize("name", ["diagnosed", "extended", "everything"])
@pytest.mark.slow
def test_every_float_that_learn_reads_is_assumed_and_demanded(name: str) -> None:
    """The bank that a learner started from among them: it is any that was committed before, not the generated one."""
    sources, _ = learn_step(model(name), texts(name), "learn")
    for path in floats_of(interface_of(name, texts(name)), f"{name}_learner_t"):
        if not path.startswith("candidate.") and path.split("[")[0] not in WILD:
            assert f"learner.{path} = Frama_C_float_interval(" in sources["step.c"], path
            assert rf"\is_finite(learner.{path}) && " in sources["step.c"], path


def test_a_kind_without_a_box_and_one_with_too_few_regressors_are_refused() -> None:
    class BoxlessTerm(Periodic):
        box = Term.box

    class ShortTerm(Periodic):
        def box(self, Ts_s: float) -> TermBox:
            return TermBox({}, (1.0,))

    class BoxlessBlock(Saturation):
        box = InputBlock.box

    for part, about in (
        (BoxlessTerm((50.0,)), "terms: periodic: gives no box"),
        (ShortTerm((50.0,)), "bounds 1 regressors, the term has 2"),
    ):
        with pytest.raises(ModelError, match=about):
            parts_box(model_with([part]))
    altered = dataclasses.replace(model("appendix_a"))
    object.__setattr__(altered, "blocks", (BoxlessBlock(130.0, 140.0),))
    with pytest.raises(ModelError, match="blocks: saturation: gives no box"):
        parts_box(altered)


def test_a_saturation_beyond_the_range_holds_the_input_at_its_level() -> None:
    box = Saturation(130.0, 140.0).box(Interval(-20.0, 120.0), 1.0)
    assert box.through == Interval(130.0, 130.0)


@pytest.mark.slow
@pytest.mark.proof
def test_eva_says_that_a_box_of_the_creep_that_is_too_small_is_left() -> None:
    need("frama-c")
    verdict, _ = prove_call(with_creep(Small, "small_diagnosed"), texts("small_diagnosed"), "predict", "finite")
    assert any("low_2" in alarm for alarm in verdict.alarms), verdict.alarms


def test_taps_and_a_learner_take_their_boxes_along() -> None:
    """Coupling with taps: each older sample has the box of the newest, in instance and learner."""
    term = Coupling(("a", "b"), (20.0, -1.0), (24.0, 3.0), taps=3)
    learner = dataclasses.replace(model_with([term]), learner=LearnerSettings())
    floats = learner_box(learner).floats
    for c in range(2):
        assert len({floats[f"terms.coupling.sample[{c}][{i}]"] for i in range(3)}) == 1
