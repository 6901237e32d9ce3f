"""Planted faults: whatever is wrong with an instruction of the simulator, some check catches it.

`pytest test_faults.py -s` prints who catches what; the table of it in docs/target.md is held to what is
found here, and written by `pytest tests/hysgen_c674x/test_faults.py --update-golden`.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures import c674x_rules as rules
from fixtures.c674x_answers import ACCESSES, ANSWERS
from fixtures.c674x_arrivals import CYCLES, arrival, bench
from fixtures.c674x_compiler import firmware, host, need_compiler
from fixtures.c674x_mistakes import MISTAKES, RIGHT, WRONG_ACTIONS
from fixtures.c674x_operations import accesses_give_the_known_answers, executed, specified
from fixtures.c674x_operations import bench as bench_of_operations
from fixtures.c674x_wrong_rules import LOOSE_LIMITS, WRONG_RULES, notices
from fixtures.opcode_table import disagreements, opcode_table
from hysgen.checking.symbolic.semantics import FLOAT, INTEGER
from hysgen.errors import BuildError, HysgenError
from hysgen_c674x import decode, latency, packets, toolchain, translation
from hysgen_c674x.assembly import Instruction
from hysgen_c674x.decode import MODELLED, Action

pytestmark = pytest.mark.slow

LEARNER_WORDS = 2 * 18 + 18 * 17 // 2


STEERING: Mapping[str, Callable[[bool], None]] = {
    "b": rules.a_branch_lands_after_five_delay_slots,
    "bnop": rules.bnop_waits_even_where_it_does_not_branch,
    "callp": rules.a_call_returns_to_the_packet_behind_it,
    "addkpc": rules.addkpc_gives_a_code_address_and_waits,
    "nop": lambda interpreted: rules.nop_n_takes_n_cycles(9, interpreted),
}
KINDS = ("what it does", "a cycle too late", "a cycle too early", "in the engine alone")


@dataclass(frozen=True)
class Planted:
    """A fault in one instruction: its kind, one of KINDS, what it is, and the checks that caught it."""

    mnemonic: str
    kind: str
    what: str
    caught: tuple[str, ...]


@pytest.fixture(scope="module")
def planted(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> list[Planted]:
    """Every fault there is, each put in and looked for."""
    need_compiler()
    found: list[Planted] = once_per_run("planted_faults", lambda: list(plant()))
    for fault in found:
        print(f"{fault.mnemonic:8} {fault.kind:20} {fault.what:28} {', '.join(fault.caught) or 'NOT CAUGHT'}")
    return found


def plant() -> Iterator[Planted]:
    monkeypatch = pytest.MonkeyPatch()
    for mnemonic, mistakes in MISTAKES.items():
        for what, wrong in mistakes.items():
            yield Planted(mnemonic, KINDS[0], what, tuple(operation_checks(mnemonic, wrong, monkeypatch)))
    for mnemonic, turned in WRONG_ACTIONS.items():
        for what, turn in turned.items():
            yield Planted(mnemonic, KINDS[0], what, tuple(action_checks(mnemonic, turn, monkeypatch)))
    for kind, step in {KINDS[1]: 1, KINDS[2]: -1}.items():
        for mnemonic, delay in latency.DELAY_SLOTS.items():
            if delay + step >= 0:
                caught = tuple(latency_checks(mnemonic, delay + step, monkeypatch))
                yield Planted(mnemonic, kind, f"{delay} -> {delay + step}", caught)
    yield from engine_faults(monkeypatch)


def test_every_instruction_that_is_modelled_has_faults_and_every_fault_is_caught(planted: list[Planted]) -> None:
    assert [fault for fault in planted if not fault.caught] == []
    by_kind = {kind: {fault.mnemonic for fault in planted if fault.kind == kind} for kind in KINDS}
    assert by_kind[KINDS[0]] == MODELLED
    assert (
        by_kind[KINDS[1]]
        == set(latency.DELAY_SLOTS)
        == {each for each in MODELLED if not each.startswith("st")} - set(STEERING)
    )
    assert by_kind[KINDS[2]] == {mnemonic for mnemonic, delay in latency.DELAY_SLOTS.items() if delay}
    assert by_kind[KINDS[3]] == set(INTEGER) | set(FLOAT)
    # A wrong operation is caught by its known answers whatever programs do.
    escaped = [
        fault
        for fault in planted
        if fault.mnemonic in MISTAKES and fault.kind == KINDS[0] and "known answers" not in fault.caught
    ]
    assert escaped == []


@pytest.mark.golden
def test_the_table_in_the_docs_is_what_was_planted(planted: list[Planted], request: pytest.FixtureRequest) -> None:
    page = Path(__file__).parents[2] / "docs" / "target.md"
    text = page.read_text(encoding="utf-8")
    before, kept, after = re.split(
        r"(?<=<!-- faults -->\n)(.*?)(?=<!-- end of faults -->)", text, maxsplit=1, flags=re.S
    )
    if request.config.getoption("--update-golden"):
        page.write_text(before + table(planted) + after, encoding="utf-8")
        kept = table(planted)
    assert kept == table(planted), "write it with pytest tests/hysgen_c674x/test_faults.py --update-golden"
    listed = re.search(r"these operations:\n\n((?:    .*\n)+)", text)
    assert listed is not None
    assert sorted(listed[1].split()) == sorted(MODELLED)


def table(planted: list[Planted]) -> str:
    """Faults that were caught and that were planted, by class of instruction and kind of fault."""
    classes = {
        "one cycle": [name for name, cycles in CYCLES.items() if cycles == 1],
        "two cycles": [name for name, cycles in CYCLES.items() if cycles == 2],
        "four cycles": [name for name, cycles in CYCLES.items() if cycles == 4],
        "loads": [name for name in ACCESSES if name.startswith("ld")],
        "stores": [name for name in ACCESSES if name.startswith("st")],
        "branches, calls, nop": sorted(STEERING),
    }
    classes["all"] = sorted(name for names in classes.values() for name in names)
    assert classes["all"] == sorted(MODELLED)
    lines = ["", f"| instructions | how many | {' | '.join(KINDS)} |", "|---|---|---|---|---|---|"]
    for label, names in classes.items():
        cells = [
            caught_of([fault for fault in planted if fault.mnemonic in names and fault.kind == kind]) for kind in KINDS
        ]
        lines.append(f"| {label} | {len(names)} | {' | '.join(cells)} |")
    rules_and_limits = (
        f"Wrong pipeline rules: {len(WRONG_RULES)} in either engine; packet limits too loose: {len(LOOSE_LIMITS)}."
    )
    lines += ["", rules_and_limits, "Each has a test of its own in `test_wrong_rules.py`."]
    return "\n".join([*lines, "", ""])


def caught_of(faults: list[Planted]) -> str:
    return f"{sum(bool(fault.caught) for fault in faults)} of {len(faults)}" if faults else "-"


def action_checks(mnemonic: str, turn: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The checks that notice an action turned wrong, on both engines."""

    def wrong(instruction: Instruction) -> Action:
        action = decode.action(instruction)
        return turn(action) if instruction.mnemonic == mnemonic else action

    with monkeypatch.context() as patch:
        patch.setattr(packets, "action", wrong)
        for interpreted, engine in ((True, "interpreter"), (False, "engine")):
            if mnemonic in STEERING:
                noticed = notices(STEERING[mnemonic], interpreted)
            else:
                noticed = notices(lambda each: accesses_give_the_known_answers(mnemonic, each), interpreted)
            if noticed:
                yield f"packets, {engine}"


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


def engine_faults(monkeypatch: pytest.MonkeyPatch) -> Iterator[Planted]:
    """All at once: each operation is judged by its own known answers."""
    texts = translation.runtime()
    wrong = re.sub(r"^(#define op_\w+\([^)]*\)) (.+)$", r"\1 ((\2) ^ 1u)", texts["operations.h"], flags=re.M)
    assert wrong.count("^ 1u") == len(RIGHT)
    with monkeypatch.context() as patch:
        patch.setattr(translation, "runtime", lambda: {**texts, "operations.h": wrong})
        bench_of_operations.cache_clear()
        for mnemonic, answers in ANSWERS.items():
            seen = any(executed(mnemonic, sources, False)[0] != expected for sources, expected in answers)
            yield Planted(mnemonic, KINDS[3], "last bit of the result", ("known answers",) if seen else ())
    bench_of_operations.cache_clear()


def latency_checks(mnemonic: str, wrong: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The checks that notice `wrong` delay slots for `mnemonic`."""
    with monkeypatch.context() as patch:
        patch.setitem(latency.DELAY_SLOTS, mnemonic, wrong)  # type: ignore[arg-type]
        bench.cache_clear()
        if arrival(mnemonic) != CYCLES[mnemonic]:
            yield "packets"
        if has_compiler() and any(disagreements(opcode_table())):
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
        predicted = decoded("predict").machine(interpreted=True).call("predict", 2.0, 50.0).bits
        machine = decoded("learn").machine(interpreted=True)
        self, phi = machine.allocate(LEARNER_WORDS), machine.allocate(18)
        machine.write(self, first_state())
        machine.write(phi, np.full(18, 0.5, np.float32))
        machine.call("learn", self, phi, 0.25, cycle_limit=20_000)
    except HysgenError:
        return True
    expected_prediction, expected_state = hosts_results()
    learned = machine.read(self, LEARNER_WORDS, np.uint32)
    return predicted != expected_prediction or not np.array_equal(learned, expected_state)


def decoded(name: str) -> toolchain.Firmware:
    """A compiled program whose packets are decoded again, by the rules as they are now."""
    return dataclasses.replace(firmware(name))


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
