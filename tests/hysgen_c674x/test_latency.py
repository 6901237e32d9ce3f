"""Every result arrives in the cycle that TI's manual and binutils' opcode table name."""

import functools

import pytest

from fixtures.c674x_answers import ANSWERS
from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_packets import DATA, RETURN, Bench
from fixtures.opcode_table import disagreements, opcode_table, write_cycles
from hysgen.checking.symbolic.semantics import READS_DESTINATION
from hysgen_c674x.decode import DELAY_SLOTS

# The pipeline types of SPRUFE8, written down apart from the table under test: cycles until the result can be read.
MANUAL = {
    1: "abs abssp add addab addad addah addaw addk and andn clr cmpeq cmpeqsp cmpgt cmpgtsp cmpgtu cmplt cmpltsp "
    "cmpltu ext extu lmbd mvk mvkh or set shl shr shru sub subab subah subaw xor",
    2: "mpy mpyh mpyhl mpyhlu mpyhu mpylh mpylhu mpysu mpyu mpyus rotl",
    4: "addsp intsp intspu mpy32 mpysp spint sptrunc subsp",
    5: "ldb ldbu lddw ldh ldhu ldndw ldnw ldw",
}
CYCLES = {mnemonic: cycles for cycles, names in MANUAL.items() for mnemonic in names.split()}
_OLD = 0x0BAD_0BAD


def arrival(mnemonic: str, interpreted: bool = True) -> int:
    """After how many cycles another instruction sees the result of `mnemonic`, found by copying it in every cycle."""
    sources = () if mnemonic in READS_DESTINATION else ANSWERS.get(mnemonic, [((), 0)])[0][0]
    registers = {f"a{4 + i}": image for i, image in enumerate(sources)}
    after = bench(interpreted).run(f"of_{mnemonic}", a8=DATA, a10=_OLD, **registers)
    copies = [after[f"b{20 + i}"] for i in range(8)]
    return 1 + next(i for i, copy in enumerate(copies) if copy != _OLD)


@functools.cache
def bench(interpreted: bool) -> Bench:
    """A function for every instruction: the instruction itself, then a copy of a10 in each cycle."""
    copies = "\n".join(f"or .L2X 0,a10,b{20 + i}" for i in range(8))
    functions = (f"of_{each}:\n{_instruction(each)}\n{copies}\n{RETURN}" for each in CYCLES)
    return Bench("\n".join(functions), interpreted)


def _instruction(mnemonic: str) -> str:
    if mnemonic.startswith("ld"):
        return f"{mnemonic} .D1T1 *+a8(0),{'a11:a10' if mnemonic in ('lddw', 'ldndw') else 'a10'}"
    if mnemonic in ("mvk", "mvkh", "addk"):
        return f"{mnemonic} .S1 65536,a10"
    if mnemonic in ("ext", "extu", "set", "clr"):
        return f"{mnemonic} .S1 a4,4,7,a10"
    operands = [f"a{4 + i}" for i in range(len(ANSWERS[mnemonic][0][0]))]
    return f"{mnemonic} .S1 {','.join([*operands, 'a10'])}"


def test_the_manual_and_the_table_name_the_same_instructions() -> None:
    assert set(CYCLES) == set(DELAY_SLOTS)


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
def test_results_arrive_when_the_manual_says(interpreted: bool) -> None:
    assert {mnemonic: arrival(mnemonic, interpreted) for mnemonic in CYCLES} == CYCLES


def test_binutils_names_the_same_cycles() -> None:
    need_compiler()
    table = opcode_table()
    assert list(disagreements(table)) == []
    assert len(write_cycles(table)) > 200  # the whole table was understood, not a part of it


def test_a_disagreement_with_binutils_is_told() -> None:
    table = "INSN(addsp, l, 1_or_2_src, 4cycle, C67X, 0,\n  OP3(ORREG1, ORXREG1, OWREG4),\n  ENC0())\n#undef x\n"
    assert list(disagreements(table, {"addsp": 3})) == []
    assert list(disagreements(table, {"addsp": 2})) == ["addsp: 2 delay slots here, written in E4 by binutils"]
    assert list(disagreements(table, {"subsp": 3})) == ["subsp: 3 delay slots here, written in nothing by binutils"]
