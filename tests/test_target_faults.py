"""Planted faults: every wrong latency, operation or pipeline rule of the simulator is caught by some check.

`pytest tests/test_target_faults.py -s` prints who catches what.
"""

from __future__ import annotations

import functools
import inspect
import math
import re
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pytest
import test_target_packets as rules
from target_answers import ANSWERS
from target_compiler import firmware, host, need_compiler
from test_target_latency import CYCLES, arrival, bench
from test_target_semantics import bench as bench_of_operations
from test_target_semantics import executed, specified

from hysgen.errors import BuildError, HysgenError
from hysgen.target import interpreter, latency, packets, toolchain, translation
from hysgen.target.semantics import FLOAT, INTEGER, FloatUnit, signed

LEARNER_WORDS = 2 * 18 + 18 * 17 // 2
RIGHT: Mapping[str, Callable[..., int]] = {**INTEGER, **FLOAT}


def without_flush(mnemonic: str) -> Callable[..., int]:
    """The operation on a unit that keeps denormals."""

    class Keeping(FloatUnit):
        def _flush(self, image: int) -> int:
            return image

    return lambda unit, *images: RIGHT[mnemonic](Keeping(), *images)


def like(other: str, *order: int) -> Callable[..., int]:
    """Another operation, its operands perhaps in another order."""

    def wrong(*images: object) -> int:
        unit = images[:1] if other in FLOAT else ()
        rest = images[len(unit) :]
        return RIGHT[other](*unit, *((rest[i] for i in order) if order else rest))

    return wrong


# For every operation the mistakes that are easy to make.
MISTAKES: Mapping[str, Mapping[str, Callable[..., int]]] = {
    "add": {"subtracts": like("sub")},
    "sub": {"operands swapped": like("sub", 1, 0)},
    "and": {"or": like("or")},
    "or": {"exclusive or": like("xor")},
    "xor": {"or": like("or")},
    "andn": {"inverts the first": like("andn", 1, 0), "and": like("and")},
    "abs": {"wraps at the most negative": lambda a: abs(signed(a)) & 0xFFFF_FFFF},
    "addab": {"scaled": like("addah")},
    "addah": {"not scaled": like("addab"), "scaled by 4": like("addaw")},
    "addaw": {"not scaled": like("addab"), "scaled by 8": like("addad")},
    "addad": {"scaled by 4": like("addaw")},
    "subab": {"adds": like("addab")},
    "subah": {"adds": like("addah"), "not scaled": like("subab")},
    "subaw": {"adds": like("addaw"), "scaled by 2": like("subah")},
    "shl": {
        "counts 5 bits": lambda a, b: a << (b & 31) & 0xFFFF_FFFF,
        "counts all bits": lambda a, b: (a << b) % 2**32,
    },
    "shr": {"fills with zeros": like("shru"), "counts 5 bits": lambda a, b: signed(a) >> (b & 31) & 0xFFFF_FFFF},
    "shru": {"fills with the sign": like("shr"), "counts 5 bits": lambda a, b: a >> (b & 31)},
    "rotl": {"shifts": like("shl"), "rotates right": lambda a, b: RIGHT["rotl"](a, 32 - b)},
    "ext": {"fills with zeros": like("extu"), "fields swapped": like("ext", 0, 2, 1)},
    "extu": {"fills with the sign": like("ext"), "fields swapped": like("extu", 0, 2, 1)},
    "set": {"clears": like("clr"), "fields swapped": like("set", 0, 2, 1)},
    "clr": {"sets": like("set"), "fields swapped": like("clr", 0, 2, 1)},
    "cmpeq": {"not equal": lambda a, b: int(a != b)},
    "cmpgt": {"unsigned": like("cmpgtu"), "or equal": lambda a, b: int(signed(a) >= signed(b))},
    "cmplt": {"unsigned": like("cmpltu"), "or equal": lambda a, b: int(signed(a) <= signed(b))},
    "cmpgtu": {"signed": like("cmpgt"), "or equal": lambda a, b: int(a >= b)},
    "cmpltu": {"signed": like("cmplt"), "or equal": lambda a, b: int(a <= b)},
    "lmbd": {"operands swapped": like("lmbd", 1, 0), "position from below": lambda b, a: 31 - RIGHT["lmbd"](b, a)},
    "mvk": {"no sign": lambda a: a & 0xFFFF},
    "mvkh": {"clears the lower half": lambda a, d: a & 0xFFFF_0000},
    "addk": {"moves": lambda a, d: a},
    "mpy": {"unsigned": like("mpyu")},
    "mpyu": {"signed": like("mpy"), "full words": lambda a, b: a * b & 0xFFFF_FFFF},
    "mpysu": {"signs swapped": like("mpyus")},
    "mpyus": {"signs swapped": like("mpysu")},
    "mpyh": {"low halves": like("mpy"), "unsigned": like("mpyhu")},
    "mpyhu": {"signed": like("mpyh")},
    "mpyhl": {"halves swapped": like("mpylh"), "unsigned": like("mpyhlu")},
    "mpylh": {"halves swapped": like("mpyhl"), "unsigned": like("mpylhu")},
    "mpyhlu": {"halves swapped": like("mpylhu"), "signed": like("mpyhl")},
    "mpylhu": {"halves swapped": like("mpyhlu"), "signed": like("mpylh")},
    "mpy32": {"low halves": like("mpyu")},
    "addsp": {"keeps denormals": without_flush("addsp"), "subtracts": like("subsp")},
    "subsp": {"keeps denormals": without_flush("subsp"), "operands swapped": like("subsp", 1, 0)},
    "mpysp": {"keeps denormals": without_flush("mpysp"), "adds": like("addsp")},
    "abssp": {
        "keeps denormals": without_flush("abssp"),
        "clears the sign of NaN only": lambda unit, a: a & 0x7FFF_FFFF,
    },
    "cmpeqsp": {"compares images": lambda unit, a, b: int(a == b), "keeps denormals": without_flush("cmpeqsp")},
    "cmpgtsp": {"operands swapped": like("cmpltsp"), "keeps denormals": without_flush("cmpgtsp")},
    "cmpltsp": {"operands swapped": like("cmpgtsp"), "keeps denormals": without_flush("cmpltsp")},
    "intsp": {"unsigned": like("intspu")},
    "intspu": {"signed": like("intsp")},
    "spint": {"truncates": like("sptrunc"), "ties away": lambda unit, a: math.floor(unit._read(a) + 0.5) & 0xFFFF_FFFF},
    "sptrunc": {"rounds": like("spint"), "toward minus infinity": lambda unit, a: math.floor(unit._read(a)) % 2**32},
}


def test_every_wrong_operation_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    assert set(MISTAKES) == set(INTEGER) | set(FLOAT)
    escaped = []
    for mnemonic, mistakes in MISTAKES.items():
        for mistake, wrong in mistakes.items():
            caught = list(operation_checks(mnemonic, wrong, monkeypatch))
            print(f"{mnemonic:8} {mistake:28} {', '.join(caught) or 'NOT CAUGHT'}")
            if "known answers" not in caught:
                escaped.append((mnemonic, mistake))
    assert escaped == []


def operation_checks(mnemonic: str, wrong: Callable[..., int], monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The checks that notice `wrong` in the specification's place."""
    engine_gives = {sources: executed(mnemonic, sources, interpreted=False)[0] for sources, _ in ANSWERS[mnemonic]}
    with monkeypatch.context() as patch:
        patch.setitem(FLOAT if mnemonic in FLOAT else INTEGER, mnemonic, wrong)  # type: ignore[arg-type]
        if any(specified(mnemonic, sources) != expected for sources, expected in ANSWERS[mnemonic]):
            yield "known answers"
        if any(specified(mnemonic, sources) != found for sources, found in engine_gives.items()):
            yield "engine"
        if used(mnemonic) and programs_differ():
            yield "programs"


def test_every_wrong_operation_of_the_engine_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    # All at once: each operation is judged by its own known answers.
    texts = translation.runtime()
    wrong = re.sub(r"^(#define op_\w+\([^)]*\)) (.+)$", r"\1 ((\2) ^ 1u)", texts["operations.h"], flags=re.M)
    assert wrong.count("^ 1u") == len(RIGHT)
    with monkeypatch.context() as patch:
        patch.setattr(translation, "runtime", lambda: {**texts, "operations.h": wrong})
        bench_of_operations.cache_clear()
        for mnemonic, answers in ANSWERS.items():
            assert any(executed(mnemonic, sources, False)[0] != expected for sources, expected in answers), mnemonic
    bench_of_operations.cache_clear()


@pytest.mark.parametrize("step", [1, -1], ids=["longer", "shorter"])
def test_every_wrong_latency_is_caught(step: int, monkeypatch: pytest.MonkeyPatch) -> None:
    escaped = []
    for mnemonic, delay in sorted(latency.DELAY_SLOTS.items()):
        if delay + step < 0:
            continue
        caught = list(latency_checks(mnemonic, delay + step, monkeypatch))
        print(f"{mnemonic:8} {delay} -> {delay + step}   {', '.join(caught) or 'NOT CAUGHT'}")
        if not caught:
            escaped.append(mnemonic)
    assert escaped == []


def latency_checks(mnemonic: str, wrong: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The checks that notice `wrong` delay slots for `mnemonic`."""
    with monkeypatch.context() as patch:
        patch.setitem(latency.DELAY_SLOTS, mnemonic, wrong)  # type: ignore[arg-type]
        bench.cache_clear()
        if arrival(mnemonic) != CYCLES[mnemonic]:
            yield "packets"
        if has_compiler() and any(latency.disagreements(toolchain.opcode_table())):
            yield "binutils"
        if used(mnemonic) and programs_differ():
            yield "programs"
    bench.cache_clear()


def has_compiler() -> bool:
    try:
        toolchain.folder()
    except BuildError:
        return False
    return True


def used(mnemonic: str) -> bool:
    """Whether the compiled programs hold the instruction."""
    listings = (firmware(name).listing for name in ("predict", "learn")) if has_compiler() else ()
    return any(f"\t{mnemonic} ." in text or f" {mnemonic} ." in text for text in listings)


def programs_differ() -> bool:
    """Whether compiled programs on the interpreter give other bits than on the host, or are refused."""
    try:
        predicted = firmware("predict").machine(interpreted=True).call("predict", 2.0, 50.0).bits
        machine = firmware("learn").machine(interpreted=True)
        self, phi = machine.allocate(LEARNER_WORDS), machine.allocate(18)
        machine.write(self, first_state())
        machine.write(phi, np.full(18, 0.5, np.float32))
        machine.call("learn", self, phi, 0.25, cycle_limit=20_000)
    except HysgenError:
        return True
    expected_prediction, expected_state = hosts_results()
    learned = machine.read(self, LEARNER_WORDS, np.uint32)
    return predicted != expected_prediction or not np.array_equal(learned, expected_state)


def first_state() -> np.ndarray:
    return np.linspace(0.5, 2.0, LEARNER_WORDS).astype(np.float32)


@functools.cache
def hosts_results() -> tuple[int, np.ndarray]:
    predicted = np.float32(host("predict", "float predict(float, float);").lib.predict(2.0, 50.0))
    library = host("learn", "void learn(void *, const float *, float);")
    state, phi = first_state(), np.full(18, 0.5, np.float32)
    library.lib.learn(library.ffi.from_buffer(state), library.ffi.from_buffer("float[]", phi), 0.25)
    return int(predicted.view(np.uint32)), state.view(np.uint32)


def test_the_unchanged_simulator_passes_the_checks_that_catch_faults() -> None:
    need_compiler()
    assert not programs_differ()


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
