"""Planted faults: every wrong latency and every wrong operation of the simulator is caught by some check.

`pytest tests/test_target_faults.py -s` prints who catches what.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np
import pytest
from target_answers import ANSWERS
from target_compiler import firmware, host, need_compiler
from test_target_latency import CYCLES, arrival, bench
from test_target_semantics import bench as bench_of_operations
from test_target_semantics import executed, specified

from hysgen.errors import BuildError, HysgenError
from hysgen.target import latency, toolchain, translation
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
