"""Cycles counted without running are the simulator's: exactly without branches, as bounds that are met with them."""

import itertools

import numpy as np
import pytest

from fixtures.c674x_compiler import firmware, need_compiler
from fixtures.c674x_packets import CODE, DATA, Bench
from hysgen.errors import TargetError
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import CycleBounds, bounds
from hysgen_c674x.machine import Machine
from hysgen_c674x.processor import RETURN_ADDRESS


def of(machine: Machine, function: str, limits: dict[int, int] | None = None) -> CycleBounds:
    return bounds(machine.image, machine.packets, function, limits)


def test_straight_line_code_has_one_cycle_count_and_the_simulator_takes_it() -> None:
    machine = firmware("predict").machine()
    found = of(machine, "predict")
    assert found.constant
    assert found.data_dependent == ()
    assert machine.call("predict", 2.0, 50.0).cycles == found.worst


def test_both_bounds_of_branching_code_are_met() -> None:
    need_compiler()
    text = (
        "float branching(float x, float y); float branching(float x, float y) {"
        " if (x < y) { x = x * y; x = x * y; x = x * y; } if (x > 1.0f) x = 1.0f; else y = y * x + y; return x * y; }"
    )
    machine = toolchain.compile([("branching.c", text)], ("-fno-if-conversion", "-fno-if-conversion2")).machine()
    found = of(machine, "branching")
    values = [-2.0, -0.5, 0.0, 0.5, 2.0]
    cycles = {machine.call("branching", x, y).cycles for x, y in itertools.product(values, values)}
    assert found.data_dependent
    assert (min(cycles), max(cycles)) == (found.best, found.worst)


def test_called_functions_are_counted_in() -> None:
    need_compiler()
    text = (
        "float outer(float x); float inner(float x); __attribute__((noinline)) float inner(float x) { return x * x; }"
        "float outer(float x) { return inner(x + 1.0f) + inner(x) * 2.0f; }"
    )
    machine = toolchain.compile([("calls.c", text)]).machine()
    found = of(machine, "outer")
    assert found.constant
    assert machine.call("outer", 3.0).cycles == found.worst > 2 * of(machine, "inner").worst


def test_a_return_through_another_register_is_a_return() -> None:
    bench = Bench("or .S2 0,b3,b7\nmvk .S2 0,b3\nb .S2 b7\nnop 5", interpreted=True)
    assert bounds(bench.image, bench.packets, "start") == CycleBounds(8, 8, ())
    assert bench.run("start").counts.cycles == 8


def test_a_stack_that_is_given_back_only_where_a_branch_is_not_taken_is_known() -> None:
    """As gcc does in the delay slots of a branch in `init` of a model with `softening`."""
    given_back = "addk .S2 16,b15\nb .S2 b3\nnop 5\n"
    text = f"addk .S2 -16,b15\n[a0] b .S1 other\n[!a0] addk .S2 16,b15\nnop 4\nb .S2 b3\nnop 5\nother:\n{given_back}"
    bench = Bench(text, interpreted=True)
    found = bounds(bench.image, bench.packets, "start")
    assert (found.best, found.worst, found.stack_bytes) == (13, 14, 16)
    unknown = Bench(text.replace("[!a0] addk", "[!a1] addk"), interpreted=True)
    with pytest.raises(TargetError, match="changed by an unknown amount"):
        bounds(unknown.image, unknown.packets, "start")


def test_a_loop_of_constant_length_has_one_cycle_count_and_the_simulator_takes_it() -> None:
    need_compiler()
    text = (
        "float nest(const float *x); float nest(const float *x) { float s = 0.0f; int i, j;"
        " for (j = 0; j < 5; j++) for (i = 0; i < 24; i++) s = s + x[i] * (float)j; return s; }"
    )
    machine = toolchain.compile([("nest.c", text)]).machine()
    found = of(machine, "nest")
    assert found.constant
    assert found.data_dependent == ()
    place = machine.allocate(24)
    machine.write(place, np.ones(24, np.float32))
    outcome = machine.call("nest", place)
    assert outcome.float32 == 240.0
    assert found.worst == outcome.cycles > 5 * 24 * 4


def test_a_loop_whose_length_is_data_needs_a_limit_and_is_exact_with_it() -> None:
    need_compiler()
    text = (
        "float sum(const float *x, int n); float sum(const float *x, int n) {"
        " float s = 0.0f; int i = 0; do { s = s + x[i]; i++; } while (i < n); return s; }"
    )
    machine = toolchain.compile([("sum.c", text)]).machine()
    with pytest.raises(
        TargetError, match=r"a loop without a limit; give one for a branch of it \(([0-9a-f]{8})\)"
    ) as no:
        of(machine, "sum")
    branch = int(str(no.value).split("(")[1].rstrip(")"), 16)
    place = machine.allocate(24)
    machine.write(place, np.ones(24, np.float32))
    outcome = machine.call("sum", place, 24)
    assert outcome.float32 == 24.0
    assert of(machine, "sum", {branch: 23}).worst == outcome.cycles


@pytest.mark.parametrize(
    ("counted", "cycles"),
    [
        # Three ways round; a load, a product, or a predicate on data, where the counter comes from: nothing is known.
        ("sub .L1 a1,1,a1", "constant"),
        ("ldw .D1T1 *a4,a1\nnop 4\nsub .L1 a1,1,a1", "without a limit"),
        ("mpy .M1 a1,1,a1\nnop 1\nsub .L1 a1,1,a1", "without a limit"),
        ("[a2] sub .L1 a1,1,a1", "without a limit"),
    ],
)
def test_a_counter_is_known_only_while_nothing_else_goes_into_it(counted: str, cycles: str) -> None:
    bench = Bench(f"mvk .S1 3,a1\nloop:\n{counted}\n[a1] b .S1 loop\nnop 5\nb .S2 b3\nnop 5", interpreted=True)
    if cycles == "constant":
        found = bounds(bench.image, bench.packets, "start")
        assert found == CycleBounds(28, 28, ())
        assert bench.run("start").counts.cycles == 28
    else:
        with pytest.raises(TargetError, match=cycles):
            bounds(bench.image, bench.packets, "start")


@pytest.mark.parametrize(
    ("start", "step", "rounds"),
    [
        *[(16, "sub .L1 a1,1,a1", 16), (16, "subab .D1 a1,1,a1", 16), (16, "subah .D1 a1,1,a1", 8)],
        *[(16, "subaw .D1 a1,1,a1", 4), (-16, "add .L1 1,a1,a1", 16), (-16, "addab .D1 a1,1,a1", 16)],
        *[(-16, "addah .D1 a1,1,a1", 8), (-16, "addaw .D1 a1,1,a1", 4), (-16, "addad .D1 a1,1,a1", 2)],
        (-16, "addk .S1 4,a1", 4),
    ],
)
def test_a_counter_is_followed_through_every_instruction_that_counts(start: int, step: str, rounds: int) -> None:
    bench = Bench(f"mvk .S1 {start},a1\nloop:\n{step}\n[a1] b .S1 loop\nnop 5\nb .S2 b3\nnop 5", interpreted=False)
    cycles = 1 + 7 * rounds + 6
    assert bounds(bench.image, bench.packets, "start") == CycleBounds(cycles, cycles, ())
    assert bench.run("start").counts.cycles == cycles


def test_a_result_under_way_is_not_known_even_if_something_else_is_written_meanwhile() -> None:
    # The load lands after the counter was set: what it brings decides, so the loop must not be taken for constant.
    text = "ldw .D1T1 *a4,a1\nmvk .S1 3,a1\nnop 3\nloop:\nsub .L1 a1,1,a1\n[a1] b .S1 loop\nnop 5\nb .S2 b3\nnop 5"
    bench = Bench(text, interpreted=True)
    with pytest.raises(TargetError, match="without a limit"):
        bounds(bench.image, bench.packets, "start")


# A caller counts down from a register that the called function preserves; the function does so by saving it, or not.
COUNTED_OVER_A_CALL = (
    "mvk .S1 3,a10\ncallp .S2 called,b3\nor .L1 0,a10,a1\nloop:\nsub .L1 a1,1,a1\n[a1] b .S1 loop\nnop 5\n"
    "or .S2 0,b8,b3\nb .S2 b3\nnop 5\ncalled:\n"
)


def test_a_register_that_the_callee_saves_is_known_after_the_call() -> None:
    saved = "stw .D1T1 a10,*a4\nmvk .S1 7,a10\nnop 3\nldw .D1T1 *a4,a10\nnop 4\nb .S2 b3\nnop 5"
    bench = Bench(COUNTED_OVER_A_CALL + saved, interpreted=True)
    ran = bench.run("start", a4=DATA, b8=RETURN_ADDRESS).counts.cycles
    assert bounds(bench.image, bench.packets, "start") == CycleBounds(ran, ran, ())


def test_a_callee_that_does_not_restore_a_register_is_refused() -> None:
    bench = Bench(COUNTED_OVER_A_CALL + "mvk .S1 7,a10\nb .S2 b3\nnop 5", interpreted=True)
    with pytest.raises(TargetError, match="a10: a function returns with another value than the caller's"):
        bounds(bench.image, bench.packets, "start")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("loop:\n[a1] b .S1 loop\nnop 5\nb .S2 b3\nnop 5", "a loop without a limit"),
        ("nop 1\n__library:\nb .S2 b7\nnop 5", "the compiler's library jumps to the address in b7"),
        ("start:\ncallp .S2 start,b3\nb .S2 b3\nnop 5", "recursion is not bounded"),
        ("addkpc .S2 back,b3,0\nback:\nb .S2 b3\nnop 5", "a call through a pointer"),
        ("rcpsp .S1 a4,a5\nb .S2 b3\nnop 5", "not modelled"),
        ("nop 1", "no execute packet starts here"),
    ],
)
def test_what_cannot_be_bounded_is_refused(text: str, complaint: str) -> None:
    bench = Bench(text, interpreted=True)
    with pytest.raises(TargetError, match=complaint):
        bounds(bench.image, bench.packets, "start")


def test_an_unconditional_loop_is_refused_not_followed() -> None:
    bench = Bench("loop:\nb .S1 loop\nnop 5", interpreted=True)
    with pytest.raises(TargetError, match=f"{CODE:08x}: a loop without a limit"):
        bounds(bench.image, bench.packets, "loop")


@pytest.mark.parametrize("seed", range(30))
def test_random_forward_branches_stay_within_the_bounds_and_meet_them(seed: int) -> None:
    # Packets with predicated branches to later labels, some in the delay slots of others; predicates from the seed.
    rng = np.random.default_rng(seed)
    lines = []
    for label in range(5):
        lines.append(f"label{label}:")
        for _ in range(int(rng.integers(1, 8))):
            kind = rng.random()
            if kind < 0.2 and label < 4:
                lines.append(f"[{rng.choice(['', '!'])}a{rng.integers(3)}] b .S1 label{rng.integers(label + 1, 5)}")
            elif kind < 0.4:
                lines.append(f"nop {rng.integers(1, 6)}")
            else:
                lines.append("add .L1 1,a4,a4")
    bench = Bench("\n".join([*lines, "b .S2 b3", "nop 5"]), interpreted=True)
    found = bounds(bench.image, bench.packets, "start")
    cycles = {
        bench.run("start", a0=a0, a1=a1, a2=a2).counts.cycles for a0, a1, a2 in itertools.product((0, 1), repeat=3)
    }
    # Nothing is written to a predicate, so each way through the code is one that some input takes.
    assert (found.best, found.worst) == (min(cycles), max(cycles))


@pytest.mark.parametrize(
    ("before", "between", "worst"),
    [
        # Two branches with their delay slots, what stands between, and the return: one of the two is taken.
        ("", "nop 1", 21),
        ("", "mvk .S1 0,a2", 21),
        # What is written to the register, or on its way there, may change the answer: neither may be taken.
        ("", "mvk .S1 0,a1", 28),
        ("", "[a2] mvk .S1 0,a1", 28),
        ("", "ldw .D1T1 *a4,a1\nnop 4", 32),
        ("ldw .D1T1 *a4,a1", "nop 1", 29),
    ],
)
def test_a_predicate_asked_again_answers_the_same_unless_it_was_written(before: str, between: str, worst: int) -> None:
    branches = f"[a1] b .S1 far\nnop 5\n{between}\n[!a1] b .S1 end\nnop 5\nfar:\nnop 9\nend:\nb .S2 b3\nnop 5"
    bench = Bench(f"{before}\n{branches}", interpreted=True)
    assert bounds(bench.image, bench.packets, "start").worst == worst


def test_stack_is_the_most_below_the_entry_on_any_way() -> None:
    """Of the function and of what it calls; it is given back before the end, and the longer way uses less."""
    call = "addk .S2 -8,b15\nstw .D2T2 b3,*+b15(4)\ncallp .S2 called,b3\nldw .D2T2 *+b15(4),b3\nnop 4\naddk .S2 8,b15"
    called = "called:\naddk .S2 -24,b15\nnop 1\naddk .S2 24,b15\nb .S2 b3\nnop 5"
    far = "far:\naddk .S2 -16,b15\nnop 9\naddk .S2 16,b15\nb .S2 b3\nnop 5"
    text = f"[a1] b .S1 far\nnop 5\n{call}\nb .S2 b3\nnop 5\n{far}\n{called}"
    bench = Bench(text, interpreted=True)
    assert [bounds(bench.image, bench.packets, name).stack_bytes for name in ("start", "far", "called")] == [32, 16, 24]
