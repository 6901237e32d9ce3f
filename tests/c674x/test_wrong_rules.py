"""Planted faults: every pipeline rule turned wrong, in interpreter and engine, fails the test that holds it."""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from c674x import test_packets as rules
from hysgen.c674x import interpreter, packets, translation
from hysgen.errors import HysgenError


@dataclass(frozen=True)
class WrongRule:
    """A rule turned wrong in the interpreter and in the engine, as (what stands there, what is put there), and the test
    that must notice.

    The engine's change is looked for in its C and, if it is not there, in the module that translates packets.
    """

    interpreter: tuple[str, str]
    engine: tuple[str, str]
    noticed_by: Callable[[bool], None]


def refusal(text: str, complaint: str) -> Callable[[bool], None]:
    return lambda engine: rules.test_what_is_forbidden_or_not_modelled_is_refused_by_name(text, complaint, engine)


def addressing(operand: str, address: int, base: int) -> Callable[[bool], None]:
    return lambda engine: rules.test_addressing_modes(operand, address, base, engine)


def waiting(text: str, stalls: int) -> Callable[[bool], None]:
    return lambda engine: rules.test_waits_of_the_cross_paths_are_counted_beside_the_cycles(text, stalls, engine)


WRONG_RULES = {
    "results land a cycle late": WrongRule(
        ("setdefault(state.cycle + delay + 1,", "setdefault(state.cycle + delay + 2,"),
        (
            "uint32_t slot = (uint32_t)(m->cycle + delay + 1) & 7;\n    uint64_t bit",
            "uint32_t slot = (uint32_t)(m->cycle + delay + 2) & 7;\n    uint64_t bit",
        ),
        lambda engine: rules.test_a_result_arrives_exactly_after_its_delay_slots("addsp .L1 a6,a7,a9", engine),
    ),
    "writes are seen within the packet": WrongRule(
        (
            "_start(instruction, action, packet, registers, state)\n",
            "_start(instruction, action, packet, registers, state)\n"
            "        new = {write.register.index: write.value for write in state.writes.get(state.cycle + 1, [])}\n"
            "        registers = tuple(new.get(index, old) for index, old in enumerate(registers))\n",
        ),
        ("m->value[slot][index] = value;", "m->value[slot][index] = m->reg[index] = value;"),
        rules.test_all_instructions_of_a_packet_read_before_any_writes,
    ),
    "predicates inverted": WrongRule(
        ("== condition.when_zero", "!= condition.when_zero"),
        ("'==' if condition.when_zero else '!='", "'!=' if condition.when_zero else '=='"),
        lambda engine: rules.test_predicates_decide_at_issue("a1", 0, 0, engine),
    ),
    "branches land a cycle early": WrongRule(
        ("lands = state.cycle + BRANCH_DELAY + 1", "lands = state.cycle + BRANCH_DELAY"),
        ("branch(m, {BRANCH_DELAY},", "branch(m, {BRANCH_DELAY - 1},"),
        rules.test_a_branch_lands_after_five_delay_slots,
    ),
    "branches land a cycle late": WrongRule(
        ("lands = state.cycle + BRANCH_DELAY + 1", "lands = state.cycle + BRANCH_DELAY + 2"),
        ("branch(m, {BRANCH_DELAY},", "branch(m, {BRANCH_DELAY + 1},"),
        rules.test_a_branch_lands_after_five_delay_slots,
    ),
    "a branch does not end a multi-cycle NOP": WrongRule(
        ("processor.program_counter, idle = target, 0", "processor.program_counter = target"),
        (
            "m->program_counter = m->branch_target[slot];\n            idle = 0;",
            "m->program_counter = m->branch_target[slot];",
        ),
        rules.test_a_branch_ends_a_multicycle_nop,
    ),
    "NOP n takes one cycle": WrongRule(
        ("idle = packet.next, packet.idle", "idle = packet.next, 0"),
        ("idle = packet->idle;", "idle = 0;"),
        lambda engine: rules.test_nop_n_takes_n_cycles(9, engine),
    ),
    "stores go before loads": WrongRule(
        ("isinstance(pair[1], Store)", "not isinstance(pair[1], Store)"),
        ("isinstance(pair[1], Store)", "not isinstance(pair[1], Store)"),
        rules.test_a_load_sees_memory_as_before_the_stores_of_its_packet,
    ),
    "a call returns to itself": WrongRule(
        ("_Write(link, packet.next,", "_Write(link, packet.address,"),
        ("_later(0, link, _value(packet.next))", "_later(0, link, _value(packet.address))"),
        rules.test_a_call_returns_to_the_packet_behind_it,
    ),
    "two results for one register pass": WrongRule(
        ("if other.register == write.register:", "if False:"),
        ("if (m->landing[slot] & bit)", "if (0)"),
        rules.test_two_results_for_one_register_in_one_cycle_are_refused,
    ),
    "two results from one unit pass": WrongRule(
        ("if write.port is not None and", "if False and"),
        ("if (m->ports[slot] & port)", "if (0)"),
        rules.test_two_results_from_one_unit_in_one_cycle_are_refused,
    ),
    "all units share one write port": WrongRule(
        ("return unit.name if", "return 'one' if"),
        ("_UNIT_BITS.get(unit.name, 0)", "1"),
        rules.test_two_results_from_one_unit_in_one_cycle_are_refused,
    ),
    "two branches at once pass": WrongRule(
        ("if lands in state.branches:", "if False:"),
        ("if (m->branch_due[slot])\n        stop", "if (0)\n        stop"),
        rules.test_two_branches_that_land_together_are_refused,
    ),
    "the base moves before a post-increment is used": WrongRule(
        ('base if memory.step == "after" else moved', "moved"),
        ("base if memory.step == 'after' else moved", "moved"),
        addressing("*a8++(4)", 0, 4),
    ),
    "the base does not move": WrongRule(
        ("    if memory.step:\n", "    if False:\n"),
        ("    if memory.step:\n", "    if False:\n"),
        addressing("*++a8(4)", 4, 4),
    ),
    "negative offsets are added": WrongRule(
        ("memory.sign * offset", "offset"),
        ("'+' if memory.sign > 0 else '-'", "'+'"),
        addressing("*-a8(8)", -8, 0),
    ),
    "register offsets are not scaled": WrongRule(
        ("(action.size if memory.scaled else 1)", "1"),
        ('f" * {action.size}u" if memory.scaled else ""', '""'),
        addressing("*+a8[a7]", 12, 0),
    ),
    "loads do not extend the sign": WrongRule(
        ("if action.signed else value", "if False else value"),
        ("if action.signed:", "if False:"),
        rules.test_bytes_halves_and_pairs_are_little_endian_and_extended,
    ),
    "the high word is the low word": WrongRule(
        ("value >> 32 * word & MASK", "value & MASK"),
        ("loaded >> {32 * word}", "loaded >> 0"),
        rules.test_bytes_halves_and_pairs_are_little_endian_and_extended,
    ),
    "misaligned accesses pass": WrongRule(
        ("if address % action.alignment:", "if False:"),
        ("if (address % alignment) {", "if (0) {"),
        refusal("ldw .D1T1 *+a8(2),a4", "not a multiple of the size"),
    ),
    "accesses outside the memory pass": WrongRule(
        ("if not MEMORY_BASE <= address", "if False and not MEMORY_BASE <= address"),
        ("if (offset > m->memory_size - size) {", "offset &= 0xFFFF;\n    if (0) {"),
        refusal("ldw .D1T1 *+a9(0),a4", "outside the memory"),
    ),
    "stores into code pass": WrongRule(
        ("if address < processor.read_only_end:", "if False:"),
        ("address < m->read_only_end", "0"),
        refusal("stw .D1T1 a4,*+a10(0)", "where code and constants lie"),
    ),
    "NaN becomes an integer unnoticed": WrongRule(
        ("raise _FaultError(Fault.NAN_TO_INTEGER) from None", "return 0"),
        ("stop(m, FAULT_NAN_TO_INTEGER, 0);", ""),
        refusal("spint .L1 a11,a4", "a NaN becomes an integer"),
    ),
    "endless loops go on": WrongRule(
        ("if state.cycle >= cycle_limit:", "if state.cycle >= 20 * cycle_limit: break\n        if False:"),
        ("if (m->cycle >= m->cycle_limit) {", "if (m->cycle >= 20 * m->cycle_limit) break;\n        if (0) {"),
        refusal("loop:\nb .S1 loop\nnop 5", "still running after 10000 cycles"),
    ),
    "loads stall cross paths": WrongRule(
        ("for write in landing if not write.load}", "for write in landing}"),
        ("|= from_memory ? 0 : bit", "|= bit"),
        waiting("ldw .D1T1 *+a8(0),a4\nnop 4\nor .L2X 0,a4,b4", 0),
    ),
    "cross paths never stall": WrongRule(
        ("stalls += bool(packet.cross_reads & just_written)", "stalls += 0"),
        ("m->stalls += (packet->cross_reads & just_written) != 0;", ""),
        waiting("mvk .S1 1,a4\nor .L2X 0,a4,b4", 1),
    ),
    "the deepest stack is forgotten": WrongRule(
        ("min(state.lowest_stack_pointer, write.value)", "write.value"),
        (" && m->reg[STACK_POINTER] < m->lowest_stack_pointer", ""),
        rules.test_the_deepest_stack_is_remembered,
    ),
}
# A limit of the packet check loosened by one, and a packet that only the right limit refuses.
LOOSE_LIMITS = {
    "_PACKET_LIMIT": ("\n|| ".join(["nop 1"] * 9), "9 instructions in one packet"),
    "_READS_PER_REGISTER": (
        "addsp .L1 a4,a4,a5\n|| addsp .S1 a4,a4,a6\n|| or .D1 0,a4,a7",
        "register read port of a4 used 5 times",
    ),
    "_UNITS_PER_CROSS_PATH": (
        "or .L1X 0,b4,a5\n|| or .S1X 0,b4,a6\n|| or .D1X 0,b4,a7",
        "cross path 1X serves 3 units",
    ),
}


@pytest.mark.parametrize("name", WRONG_RULES)
def test_every_wrong_rule_of_the_interpreter_is_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = WRONG_RULES[name]
    wrong.noticed_by(True)
    monkeypatch.setattr(interpreter, "run", changed_module(interpreter, *wrong.interpreter).run)
    assert notices(wrong.noticed_by, True)


@pytest.mark.parametrize("name", WRONG_RULES)
def test_every_wrong_rule_of_the_engine_is_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = WRONG_RULES[name]
    old, new = wrong.engine
    texts = translation.runtime()
    if any(old in text for text in texts.values()):
        changed = {file: text.replace(old, new) for file, text in texts.items()}
        monkeypatch.setattr(translation, "runtime", lambda: changed)
    else:
        monkeypatch.setattr(translation, "program", changed_module(translation, old, new).program)
    assert notices(wrong.noticed_by, False)


@pytest.mark.parametrize("limit", LOOSE_LIMITS)
def test_every_loose_limit_of_a_packet_is_caught(limit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    packet, complaint = LOOSE_LIMITS[limit]
    rules.test_a_packet_beyond_the_processors_resources_is_refused(packet, complaint)
    monkeypatch.setattr(packets, limit, getattr(packets, limit) + 1)
    assert notices(lambda _: rules.test_a_packet_beyond_the_processors_resources_is_refused(packet, complaint), True)


def notices(check: Callable[[bool], None], interpreted: bool) -> bool:
    """Whether a test fails, in whichever way."""
    try:
        check(interpreted)
    except (AssertionError, HysgenError, pytest.fail.Exception):
        return True
    return False


def changed_module(module: types.ModuleType, old: str, new: str) -> types.ModuleType:
    """A copy of a module in whose text `old` has become `new`."""
    text = inspect.getsource(module)
    assert old in text, f"{module.__name__} does not hold: {old}"
    copy = types.ModuleType(module.__name__)
    # Dataclasses look their module up by name, so the copy goes by the original's.
    exec(compile(text.replace(old, new), str(module.__file__), "exec", dont_inherit=True), copy.__dict__)
    return copy
