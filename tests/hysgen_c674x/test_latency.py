"""Every result arrives in the cycle that TI's manual and binutils' opcode table name."""

from __future__ import annotations

import pytest

from fixtures.c674x_arrivals import CYCLES, arrival
from fixtures.c674x_compiler import need_compiler
from fixtures.opcode_table import disagreements, opcode_table, write_cycles
from hysgen_c674x.latency import DELAY_SLOTS


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
