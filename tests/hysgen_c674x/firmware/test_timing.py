"""Time from the A/D to the D/A on the simulator, with and without the learner; the model of the caches."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import model
from hysgen.firmware import binding
from hysgen.firmware.binding import firmware_model, with_learner
from hysgen.model.file import load_model
from hysgen_c674x import toolchain
from hysgen_c674x.caches import L1D_LINE, L1D_SETS, L1P_LINE, L1P_SETS, Caches, Misses
from hysgen_c674x.firmware.simulated import compile_image
from hysgen_c674x.firmware.timing import LEARN, TRIM, Timing, tracked
from hysgen_c674x.machine import Machine
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import AccessKind, Trace
from hysgen_c674x.schedule.folder import kernels, with_kernels

PAGE = Path(__file__).resolve().parents[3] / "docs" / "firmware.md"
FETCH, LOAD, STORE = AccessKind.FETCH, AccessKind.LOAD, AccessKind.STORE


@functools.cache
def without_and_with_learner() -> tuple[Timing, Timing]:
    compiled = compile_image(firmware_model(model()))
    return tracked(model(), compiled.machine(), TRIM), tracked(model(), compiled.machine(), TRIM | LEARN)


@pytest.mark.slow
def test_the_learner_does_not_delay_the_output() -> None:
    """Same cycles from the reading to the voltage, sample by sample; without a commit the voltages are equal."""
    need_compiler()
    without, learning = without_and_with_learner()
    assert learning.delay == without.delay
    assert min(learning.total) > max(without.total)
    assert learning.cold.lines > without.cold.lines > without.warm.lines


@pytest.mark.golden
@pytest.mark.slow
def test_the_page_states_the_cycles_to_the_output() -> None:
    need_compiler()
    without, learning = without_and_with_learner()
    page = PAGE.read_text(encoding="utf-8")
    for name, each in {"trim": without, "trim, learner": learning}.items():
        row = f"| Appendix A, {name} | {min(each.delay)} .. {max(each.delay)} | {max(each.total)} |"
        assert row in page, row


@pytest.mark.slow
def test_a_learner_before_the_output_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    need_compiler()
    read = binding.read_sources
    behind = (
        "    hysgen_board_voltage(board, hysgen_controller_step(&self->controller, y_um, reference_um, amplifier));\n"
    )
    moved = (
        "    const float u_V = hysgen_controller_step(&self->controller, y_um, reference_um, amplifier);\n"
        "    hysgen_controller_learn(&self->controller);\n    hysgen_board_voltage(board, u_V);\n"
    )

    def planted(folder: str, *patterns: str) -> binding.Sources:
        return [(name, text.replace(behind, moved)) for name, text in read(folder, *patterns)]

    monkeypatch.setattr("hysgen_c674x.firmware.simulated.read_sources", planted)
    compiled = compile_image(firmware_model(model()))
    without, learning = (tracked(model(), compiled.machine(), options) for options in (TRIM, TRIM | LEARN))
    assert min(learning.delay) > max(without.delay) + 500


@pytest.mark.proof
def test_with_kernels_the_extended_model_learns_within_its_period() -> None:
    """Interrupt in TRACK with the learner, behind the idle loop: 500 of 7500 cycles left at 6 cycles a missed line."""
    need_compiler()
    extended = with_learner(load_model("extended"))
    texts = firmware_model(extended, aligned=True)
    texts = with_kernels(extended.name, texts, kernels(extended.name, texts))
    found = tracked(extended, compile_image(texts).machine(), TRIM | LEARN, idle=True)
    assert found.left(7500, 6, found.warm) > 500
    assert found.warm.lines < 400


def trace(*accesses: tuple[AccessKind, int]) -> Trace:
    """A trace of (kind, address)."""
    made = Trace(len(accesses))
    for cycle, (kind, address) in enumerate(accesses):
        made.add(cycle, kind, address)
    return made


def packets(*addresses: int, size: int = 4) -> dict[int, Packet]:
    """Packets of `size` bytes."""
    return {at: Packet(at, at + size, (), (), 0, frozenset(), None) for at in addresses}


def test_program_lines_that_share_a_set_replace_each_other() -> None:
    base, far = 0x1180_0000, 0x1180_0000 + L1P_LINE * L1P_SETS
    run = trace((FETCH, base), (FETCH, base), (FETCH, far), (FETCH, base))
    assert Caches(packets(base, far)).run(run) == Misses(3, 0)


def test_a_packet_across_two_lines_fetches_both() -> None:
    base = 0x1180_0000 + L1P_LINE - 4
    assert Caches(packets(base, size=8)).run(trace((FETCH, base))) == Misses(2, 0)


def test_data_lines_replace_the_least_recently_used_of_two_and_stores_take_none() -> None:
    a, b, c = (0x1180_0000 + i * L1D_LINE * L1D_SETS for i in range(3))
    caches = Caches({})
    assert caches.run(trace((STORE, a), (LOAD, a), (LOAD, b), (LOAD, a))) == Misses(0, 2)
    # b was used least recently: c takes its place, a stays.
    assert caches.run(trace((LOAD, c), (LOAD, a), (LOAD, b))) == Misses(0, 2)


def test_engine_and_interpreter_trace_the_same_accesses() -> None:
    need_compiler()
    text = "float sum(const float *x); float sum(const float *x) { return x[0] + x[1] + x[2]; }"
    built = toolchain.compile([("sum.c", text)])
    found = []
    for interpreted in (False, True):
        machine = Machine(built.image, built.packets, interpreted)
        place = machine.allocate(4)
        machine.write(place, [1.0, 2.0, 3.0])
        outcome, made = machine.trace("sum", place)
        assert outcome.float32 == 6.0
        found.append(made.words[: made.count].tolist())
    assert found[0] == found[1]
    assert sum(word >> 32 & 3 == LOAD for word in found[0]) >= 2
