"""start.s on the simulated C674x: start-up, and an interrupt before every packet of the code that it interrupts.

The interrupt's C function is replaced by one that changes every register that the ABI lets it change. The interrupted
code must leave the same registers and memory as without the interrupt.
"""

import functools
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_kernels import scheduled_model
from fixtures.firmware_bench import ModelStage, model
from hysgen.firmware import CONTROLLER, EMPTY_STORE, SIMULATOR_BOARD, TARGET_BOARD, firmware_model, read_sources
from hysgen.firmware.wire import State
from hysgen.model.model import Model
from hysgen_c674x import interpreter, toolchain
from hysgen_c674x.cycles import c_texts
from hysgen_c674x.machine import Machine
from hysgen_c674x.processor import MEMORY_BASE, RETURN_ADDRESS, STACK_POINTER
from hysgen_c674x.schedule.folder import kernels, with_kernels

CONTROL = ("amr", "fadcr", "fmcr", "istp", "tsr")
LINK = 32 + 3
STACK_TOP = 0x1183_F000
RESTING_AMR = 0x0001_0004
"""Circular addressing by A5, as hand-written code may use it."""

VICTIM = """
#include <stdint.h>
uint32_t started;
void hysgen_start(void);
void hysgen_start(void) { started = 0x600DF00Du; }
uint32_t panicked;
void hysgen_main_panic(void);
void hysgen_main_panic(void) { panicked = 1u; }
int32_t eleven(int32_t a, int32_t b, int32_t c, int32_t d, int32_t e, int32_t f, int32_t g, int32_t h, int32_t i,
               int32_t j, int32_t k) __attribute__((noinline));
int32_t eleven(int32_t a, int32_t b, int32_t c, int32_t d, int32_t e, int32_t f, int32_t g, int32_t h, int32_t i,
               int32_t j, int32_t k)
{
    return a + 2 * b + 3 * c + 4 * d + 5 * e + 6 * f + 7 * g + 8 * h + 9 * i + 10 * j + 11 * k;
}
int32_t victim(int32_t a);
int32_t victim(int32_t a)
{
    return eleven(a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6, a + 7, a + 8, a + 9, a + 1000) ^ a;
}
"""


def changing() -> str:
    """hysgen_main_tick of the tests: assembly that changes all that a C function may change."""
    free = [f"A{i}" for i in (*range(10), *range(16, 32))] + [f"B{i}" for i in (0, 1, 2, *range(4, 10), *range(16, 32))]
    lines = [f"        mvk .S{1 if name[0] == 'A' else 2} {-300 - 7 * i}, {name}" for i, name in enumerate(free)]
    lines += ["        stw .D2T2 B4, *B15", "        b .S2 B3", "        nop 5"]
    return "\n".join(
        ["        .nocmp", "        .text", "        .global hysgen_main_tick", "hysgen_main_tick:", *lines, ""]
    )


def plant(scheduled: bool) -> Model:
    """The paper's model, or one of two rules, whose kernels are scheduled five times faster; both learn."""
    return scheduled_model("small_learning") if scheduled else model()


@functools.cache
def machine(scheduled: bool = False) -> Machine:
    """Controller, model, simulator's board, start.s and the functions above, in the memories of the C6748.

    scheduled: with the functions of a model of two rules as kernels; every function with a kernel has one.
    """
    need_compiler()
    texts = firmware_model(plant(scheduled), aligned=scheduled)
    if scheduled:
        texts = with_kernels(plant(scheduled).name, texts, kernels(plant(scheduled).name, texts))
    generated = c_texts(texts)
    script = dict(read_sources(TARGET_BOARD, "*.ld"))["c6748.ld"]
    board = [*read_sources(SIMULATOR_BOARD), *read_sources(*EMPTY_STORE), *read_sources(TARGET_BOARD, "*.s")]
    sources = [*read_sources(CONTROLLER), *board, *generated, ("victim.c", VICTIM), ("changing.s", changing())]
    return toolchain.compile(sources, script=script).machine()


@dataclass
class Preempted:
    """A run on the interpreter, with the control registers that it does not model.

    interrupt_at: the interrupt comes before this packet, counted from 0, or as soon after it as the code allows;
    None: never.
    """

    machine: Machine
    registers: list[int]
    interrupt_at: int | None = None
    control: dict[str, int] = field(default_factory=lambda: {name: 0xCDCD for name in CONTROL})
    issued: int = 0
    taken: bool = False

    def run(self, entry: int, last: int = RETURN_ADDRESS) -> None:
        """From `entry` until a branch to `last` has landed."""
        processor = self.machine.processor
        processor.registers, processor.program_counter = self.registers, entry
        state, idle = interpreter.PipelineState(processor), 0
        while True:
            interpreter.land(state)
            target = state.branches.pop(state.cycle, None)
            if target is not None:
                processor.program_counter, idle = target, 0
            if processor.program_counter == last and not idle and not state.branches:
                break
            assert state.cycle < 100_000
            if idle:
                idle -= 1
            elif self._due(state):
                self._interrupt(state)
                continue
            else:
                idle = self._issue(state)
            state.cycle += 1
        drain(state)
        self.registers = processor.registers

    def _due(self, state: interpreter.PipelineState) -> bool:
        """Interrupts are taken between packets that are in no branch's delay slots."""
        return (
            self.interrupt_at is not None and not self.taken and self.issued >= self.interrupt_at and not state.branches
        )

    def _interrupt(self, state: interpreter.PipelineState) -> None:
        """Results on their way arrive before the first packet of the interrupt; its return goes to RETURN_ADDRESS."""
        self.taken = True
        processor, back = state.processor, state.processor.program_counter
        drain(state)
        inner = Preempted(self.machine, list(processor.registers), control=self.control)
        inner.run(self.machine.address("tick"))
        processor.registers, processor.program_counter = inner.registers, back

    def _issue(self, state: interpreter.PipelineState) -> int:
        """Issue the packet at the program counter; returns its idle cycles."""
        processor = state.processor
        packet = processor.packets[processor.program_counter]
        processor.program_counter = packet.next
        self.issued += 1
        alone = packet.instructions[0]
        if alone.mnemonic == "mvc":
            source, destination = (str(each) for each in alone.operands)
            if destination in self.control:
                self.control[destination] = processor.registers[alone.operands[0].index]  # type: ignore[union-attr]
            else:
                processor.registers[alone.operands[1].index] = self.control[source]  # type: ignore[union-attr]
            return 0
        if alone.mnemonic == "b" and alone.operands == ("irp",):
            state.branches[state.cycle + 6] = RETURN_ADDRESS
            return 0
        assert packet.refusal is None, packet.refusal
        interpreter.issue(packet, state)
        return packet.idle


def drain(state: interpreter.PipelineState) -> None:
    """Let results on their way arrive."""
    while state.writes:
        state.cycle += 1
        interpreter.land(state)


def called(function: str, argument: int, memory: bytes, interrupt_at: int | None) -> tuple[Preempted, bytes]:
    """Call `function` on a copy of `memory`; returns the run and the memory without the free part of the stack."""
    target = machine()
    target.processor.memory[:] = memory
    registers = [0x5A00_0000 + index for index in range(64)]
    registers[4], registers[STACK_POINTER], registers[LINK] = argument, STACK_TOP, RETURN_ADDRESS
    run = Preempted(target, registers, interrupt_at)
    run.control["amr"] = RESTING_AMR
    run.run(target.address(function))
    here = bytes(target.processor.memory)
    top = STACK_TOP - MEMORY_BASE
    return run, here[: top - 0x2000] + here[top:]


def preempted_at_every_packet(function: str, argument: int, memory: bytes) -> tuple[int, int]:
    """Interrupts that were taken, and words of registers and memory that differ from the run without an interrupt."""
    alone, expected = called(function, argument, memory, None)
    expected_words = np.frombuffer(expected, np.uint32)
    taken = differing = 0
    for packet in range(alone.issued):
        run, found = called(function, argument, memory, packet)
        taken += run.taken
        live = (4, *range(10, 16), *range(32 + 10, 32 + 16))
        differing += sum(run.registers[index] != alone.registers[index] for index in live)
        differing += int((np.frombuffer(found, np.uint32) != expected_words).sum())
        differing += run.control != alone.control
    return taken, differing


@pytest.mark.slow
def test_an_interrupt_before_any_packet_leaves_arguments_on_the_stack_alone() -> None:
    """The eleventh argument lies at SP+4 of its caller (SPRAB89, 4.3)."""
    memory = bytes(machine().processor.memory)
    taken, differing = preempted_at_every_packet("victim", 12345, memory)
    assert taken > 10
    assert differing == 0


@pytest.mark.parametrize("scheduled", [False, True], ids=["C", "kernels"])
@pytest.mark.slow
def test_an_interrupt_before_any_packet_of_the_idle_loop_changes_no_word(
    scheduled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The idle loop of a firmware that tracks and learns, in three phases of a commit; inverse and learn interrupt.

    With kernels in one phase: the code of commit that is not a kernel is the same.
    """
    wanted = 1 if scheduled else 3
    if scheduled:
        monkeypatch.setattr(sys.modules[__name__], "machine", functools.partial(machine, scheduled=True))
    target, stage = machine(), ModelStage(plant(scheduled))
    target.call("hysgen_simulated_boot")
    taken, y_um, phases = 0, stage.y_um, 0
    for k in range(1500):
        u_V = target.call("hysgen_simulated_interrupt", np.float32(y_um), np.float32(2.0 + 0.6 * np.sin(0.0063 * k)))
        state = target.call("hysgen_simulated_state").bits & 0xFF
        if state == State.TRACK and k % 16 == 0 and phases < wanted:
            memory = bytes(target.processor.memory)
            interrupts, differing = preempted_at_every_packet("hysgen_simulated_idle", 0, memory)
            taken, phases = taken + interrupts, phases + 1
            assert differing == 0
            target.processor.memory[:] = memory
        if phases == wanted:
            break
        target.call("hysgen_simulated_idle")
        y_um = stage.step(None, u_V.float32)
    assert phases == wanted
    assert taken > 100


def test_start_up_sets_stack_vectors_and_modes_and_calls_start() -> None:
    target = machine()
    registers = [0x5A00_0000 + index for index in range(64)]
    run = Preempted(target, registers)
    run.run(target.address("_c_int00"), last=target.address("stay"))
    top = target.address("hysgen_stack_top")
    assert run.registers[STACK_POINTER] == top
    assert top % 8 == 0
    assert target.view("started", 1, np.uint32)[0] == 0x600DF00D
    assert run.control == {"amr": 0, "fadcr": 0, "fmcr": 0, "istp": target.address("hysgen_vectors"), "tsr": 12}


@pytest.mark.parametrize(("slot", "leads_to"), [(0, "_c_int00"), (1, "hysgen_panic"), (4, "tick")])
def test_each_vector_ends_in_its_own_slot(slot: int, leads_to: str) -> None:
    """A slot is eight instructions; the branch lands before the next slot begins."""
    packets: Mapping[int, object] = machine().packets
    first = packets[machine().address("hysgen_vectors") + 32 * slot].instructions[0]  # type: ignore[attr-defined]
    assert first.mnemonic == "b"
    assert first.operands[0].address == machine().address(leads_to)


def test_an_exception_leaves_a_broken_stack_and_ends_in_the_firmwares_last_words() -> None:
    target = machine()
    registers = [0x5A00_0000 + index for index in range(64)]
    registers[STACK_POINTER] = 0xDEAD_BEE0
    run = Preempted(target, registers)
    run.control["amr"] = RESTING_AMR
    run.run(target.address("hysgen_panic"), last=target.address("halt"))
    assert run.registers[STACK_POINTER] == target.address("hysgen_stack_top")
    assert run.control["amr"] == 0
    assert target.view("panicked", 1, np.uint32)[0] == 1
