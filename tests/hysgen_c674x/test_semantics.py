"""Every operation gives its known answers, and the two implementations of it agree on everything else."""

import functools
import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from fixtures.c674x_answers import ACCESSES, ANSWERS, PATTERN, STORED, UNTOUCHED
from fixtures.c674x_packets import DATA, Bench, index, run
from hysgen.checking.symbolic.semantics import FLOAT, INTEGER, READS_DESTINATION, FloatUnit, from_image, to_image
from hysgen.errors import TargetError
from hysgen_c674x.decode import DELAY_SLOTS, MODELLED
from hysgen_c674x.processor import MEMORY_BASE, RunCounts

OPERATIONS = sorted([*INTEGER, *FLOAT])
# The bit fields of these, and the whole constant of those, are part of the opcode.
FIELD_OPERATIONS = ("ext", "extu", "set", "clr")
CONSTANT_OPERATIONS = ("mvk", "mvkh", "addk")
REGISTER_OPERATIONS = [each for each in OPERATIONS if each not in FIELD_OPERATIONS + CONSTANT_OPERATIONS]


def accesses_give_the_known_answers(mnemonic: str, interpreted: bool) -> None:
    """The check of one load or store, on the interpreter or on the engine."""

    for answer in ACCESSES[mnemonic]:
        assert accessed(mnemonic, answer.offset, interpreted) == answer.left
        if answer.refused is not None:
            with pytest.raises(TargetError, match="not a multiple of the size"):
                accessed(mnemonic, f"({answer.refused})", interpreted)


def accessed(mnemonic: str, offset: str, interpreted: bool) -> tuple[int, ...] | bytes:
    """What one access, at `offset` from PATTERN, leaves: registers of a load, memory behind a store."""
    data = "a11:a10" if mnemonic in ("lddw", "ldndw", "stdw", "stndw") else "a10"
    memory = {DATA + 4 * i: int.from_bytes(PATTERN[4 * i : 4 * i + 4], "little") for i in range(4)}
    if mnemonic.startswith("ld"):
        text = f"{mnemonic} .D1T1 *+a8{offset},{data}\nnop 4"
        after = run(text, interpreted, memory, a8=DATA, a10=UNTOUCHED, a11=UNTOUCHED)
        return after["a10"], after["a11"]
    after = run(f"{mnemonic} .D1T1 {data},*+a8{offset}", interpreted, memory, a8=DATA, a10=STORED[0], a11=STORED[1])
    return bytes(after.memory[DATA - MEMORY_BASE :][:16])


def specified(mnemonic: str, sources: tuple[int, ...], unit: FloatUnit | None = None) -> int:
    if mnemonic in FLOAT:
        return FLOAT[mnemonic](unit or FloatUnit(), *sources)
    return INTEGER[mnemonic](*sources)


def executed(mnemonic: str, sources: tuple[int, ...], interpreted: bool) -> tuple[int, RunCounts]:
    """The result of one instruction, its register sources set before."""
    constants, registers = split(mnemonic, sources)
    first = index("a9" if mnemonic in READS_DESTINATION else "a4")
    named = {f"a{first + offset}": image for offset, image in enumerate(registers)}
    after = bench(interpreted).run(label(mnemonic, constants), **named)
    return after["a9"], after.counts


def label(mnemonic: str, constants: tuple[int, ...]) -> str:
    return "_".join(["entry", mnemonic, *map(str, constants)])


def split(mnemonic: str, sources: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Which sources are constants in the opcode, which come from registers."""
    if mnemonic in FIELD_OPERATIONS:
        return sources[1:], sources[:1]
    if mnemonic in CONSTANT_OPERATIONS:
        return sources[:1], sources[1:]
    return (), sources


@functools.cache
def bench(interpreted: bool) -> Bench:
    """A function for every operation, and for every set of constants in its opcode that an answer asks for."""
    functions: dict[str, str] = {}
    for mnemonic, sources in ((each, sources) for each in OPERATIONS for sources, _ in ANSWERS[each]):
        constants, registers = split(mnemonic, sources)
        printed = [str(value - 2**32 if value >= 2**31 else value) for value in constants]
        if mnemonic not in READS_DESTINATION:
            operands = [f"a{4 + i}" for i in range(len(registers))]
            printed = [*operands, *printed] if mnemonic in FIELD_OPERATIONS else [*printed, *operands]
        functions[label(mnemonic, constants)] = f"b .S2 b3\n{mnemonic} .S1 {','.join([*printed, 'a9'])}\nnop 4"
    return Bench("\n".join(f"{name}:\n{text}" for name, text in functions.items()), interpreted)


def test_every_operation_has_known_answers_and_a_latency() -> None:
    assert set(ANSWERS) == set(OPERATIONS)
    assert set(OPERATIONS) <= set(DELAY_SLOTS)
    # Whatever else is modelled: loads and stores have answers too, and the rest steers.
    assert MODELLED - set(OPERATIONS) - set(ACCESSES) == {"b", "bnop", "callp", "addkpc", "nop"}


@pytest.mark.golden
def test_the_page_lists_what_is_modelled() -> None:
    page = (Path(__file__).parents[2] / "docs" / "target.md").read_text(encoding="utf-8")
    listed = re.search(r"these operations:\n\n((?:    .*\n)+)", page)
    assert listed is not None
    assert sorted(listed[1].split()) == sorted(MODELLED)


@pytest.mark.parametrize("mnemonic", OPERATIONS)
def test_the_specification_gives_the_known_answers(mnemonic: str) -> None:
    for sources, expected in ANSWERS[mnemonic]:
        assert hex(specified(mnemonic, sources)) == hex(expected), sources


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
@pytest.mark.parametrize("mnemonic", OPERATIONS)
def test_instructions_give_the_known_answers(mnemonic: str, interpreted: bool) -> None:
    for sources, expected in ANSWERS[mnemonic]:
        assert hex(executed(mnemonic, sources, interpreted)[0]) == hex(expected), sources


@pytest.mark.parametrize("mnemonic", REGISTER_OPERATIONS)
def test_engine_and_specification_agree_on_random_and_extreme_operands(mnemonic: str) -> None:
    rng = np.random.default_rng(OPERATIONS.index(mnemonic))
    arity = len(ANSWERS[mnemonic][0][0])
    extremes = [0, 1, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, 0x0080_0000, 0x0000_0001, 0x7F7F_FFFF, 0x3F80_0001]
    tuples = list(itertools.product(extremes, repeat=arity))
    tuples += [tuple(int(x) for x in row) for row in rng.integers(0, 2**32, (100, arity), dtype=np.uint64)]
    # Operands of like size too: sums that cancel, comparisons that come out close, shifts within the word.
    tuples += [(row[0], *(row[0] ^ int(n) for n in rng.integers(0, 64, arity - 1))) for row in tuples[-50:]]
    tuples += [(row[0], *(int(n) for n in rng.integers(0, 64, arity - 1))) for row in tuples[-50:]]
    for sources in tuples:
        unit = FloatUnit()
        try:
            expected = specified(mnemonic, sources, unit)
        except ValueError:
            with pytest.raises(TargetError, match="NaN becomes an integer"):
                executed(mnemonic, sources, interpreted=False)
            continue
        found, counts = executed(mnemonic, sources, interpreted=False)
        assert hex(found) == hex(expected), [hex(source) for source in sources]
        assert (counts.denormals, counts.nans) == (unit.denormals, unit.nans)


@pytest.mark.parametrize("mnemonic", ["addsp", "subsp", "mpysp"])
def test_arithmetic_on_normal_numbers_is_the_hosts_float32(mnemonic: str) -> None:
    rng = np.random.default_rng(5)
    images = rng.integers(0x2000_0000, 0x5F00_0000, (20_000, 2)).astype(np.uint32)
    images |= (rng.integers(0, 2, images.shape) << 31).astype(np.uint32)
    a, b = images.view(np.float32).T
    host = {"addsp": a + b, "subsp": a - b, "mpysp": a * b}[mnemonic].astype(np.float32).view(np.uint32)
    normal = (host & 0x7F80_0000 != 0) & (host & 0x7F80_0000 != 0x7F80_0000)
    assert normal.mean() > 0.9
    for (left, right), expected in zip(images[normal].tolist(), host[normal].tolist(), strict=True):
        assert specified(mnemonic, (left, right)) == expected


@pytest.mark.parametrize("value", [0.0, -0.0, 1.0, -3.25, 2.0**-126, 3.4e38, float("inf")])
def test_images_round_trip(value: float) -> None:
    assert str(from_image(to_image(value))) == str(float(np.float32(value)))


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
@pytest.mark.parametrize("mnemonic", ACCESSES)
def test_loads_and_stores_give_the_known_answers(mnemonic: str, interpreted: bool) -> None:
    accesses_give_the_known_answers(mnemonic, interpreted)


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
def test_interrupt_flags_are_set_and_cleared_bit_by_bit_from_4_on(interpreted: bool) -> None:
    flags = "mvc .S2 b4,isr\nnop 1\nmvc .S2 ifr,b5\nmvc .S2 b6,icr\nnop 1\nmvc .S2 ifr,b7"
    after = run(f"{flags}\nb .S2 b3\nnop 5", interpreted, b4=0xF0F2, b6=0x3010)
    assert (after["b5"], after["b7"]) == (0xF0F0, 0xC0E0)
