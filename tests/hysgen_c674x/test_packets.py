"""The interpreter and the compiled engine keep every rule of the pipeline: one hand-written packet sequence for each.

The expected registers follow from TI's description of the pipeline (SPRUFE8), worked out by hand in the comments.
"""

import pytest

from fixtures.c674x_packets import CODE, DATA, RETURN, After, bits, run
from hysgen.errors import TargetError
from hysgen_c674x.assembly import instructions
from hysgen_c674x.packets import packets


@pytest.fixture(params=[True, False], ids=["interpreter", "engine"])
def interpreted(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


def test_bars_join_neighbours_only() -> None:
    # Code that ends one section and a bar that starts another are not one packet.
    apart = f"{CODE:x}:\t00000000 \tnop 1\n{CODE + 64:x}:\t00000000 \t|| mvk .S1 1,a4"
    found = packets(instructions(apart))
    assert [len(packet.instructions) for packet in found.values()] == [1, 1]
    assert "parallel to nothing" in str(found[CODE + 64].refusal)


def test_all_instructions_of_a_packet_read_before_any_writes(interpreted: bool) -> None:
    after = run("or .L1 0,a5,a4\n|| or .S1 0,a4,a5", interpreted, a4=1, a5=2)
    assert (after["a4"], after["a5"]) == (2, 1)


def test_a_later_short_result_may_overtake_an_earlier_long_one(interpreted: bool) -> None:
    # The load lands in cycle 5, the constant in cycle 2: the loaded word is what remains.
    after = run("ldw .D1T1 *+a8(0),a4\nmvk .S1 7,a4\nor .L1 0,a4,a5", interpreted, memory={DATA: 99}, a8=DATA)
    assert (after["a5"], after["a4"]) == (7, 99)


def test_two_results_for_one_register_in_one_cycle_are_refused(interpreted: bool) -> None:
    with pytest.raises(TargetError, match="two results reach register a4 in one cycle"):
        run("addsp .L1 a6,a7,a4\nnop 2\nmvk .S1 1,a4", interpreted)


def test_opposite_predicates_may_write_one_register(interpreted: bool) -> None:
    after = run("[a1] mvk .S1 1,a4\n|| [!a1] mvk .L1 2,a4", interpreted, a1=0)
    assert after["a4"] == 2


def test_two_results_from_one_unit_in_one_cycle_are_refused(interpreted: bool) -> None:
    with pytest.raises(TargetError, match="two results leave one functional unit in one cycle"):
        run("addsp .L1 a6,a7,a4\nnop 2\nor .L1 0,a6,a5", interpreted)
    # Another unit has a port of its own, and so has the load path.
    run("addsp .L1 a6,a7,a4\nnop 2\nor .S1 0,a6,a5", interpreted)
    run("ldw .D1T1 *+a8(0),a4\nnop 3\nor .D1 0,a6,a5", interpreted, a8=DATA)


@pytest.mark.parametrize(("predicate", "a1", "executed"), [("a1", 0, 0), ("a1", 5, 1), ("!a1", 0, 1), ("!a1", 5, 0)])
def test_predicates_decide_at_issue(predicate: str, a1: int, executed: int, interpreted: bool) -> None:
    # a1 is inverted in the same packet and in the delay slots: what counts is its value at issue.
    after = run(
        f"[{predicate}] mvk .S1 1,a4\n|| cmpeq .L1 0,a1,a1\n[{predicate}] addsp .L1 a6,a7,a5\n|| or .S1 0,a1,a10",
        interpreted,
        a1=a1,
        a4=0,
        a6=bits(1.0),
        a7=bits(2.0),
    )
    assert after["a4"] == executed
    assert (after["a5"] == bits(3.0)) == (not executed)


def test_an_instruction_not_executed_touches_nothing(interpreted: bool) -> None:
    # Addresses that would fault, a branch that would leave: nothing happens under a false predicate.
    after = run(
        "[a1] ldw .D1T1 *+a9(0),a4\n[a1] stw .D1T1 a4,*+a9(0)\n[a1] b .S1 away\n"
        "mvk .S1 3,a5\nnop 5\nmvk .S1 4,a6\nb .S2 b3\nnop 5\naway:\nnop 1",
        interpreted,
        a1=0,
        a9=3,
    )
    assert (after["a5"], after["a6"]) == (3, 4)


def test_a_branch_lands_after_five_delay_slots(interpreted: bool) -> None:
    after = run(
        "b .S1 there\n"
        + "add .L1 1,a4,a4\n" * 5
        + "mvk .S1 -1,a4\n"  # the sixth packet after the branch is not reached
        + "b .S2 b3\nnop 5\nthere:\nadd .L1 1,a4,a5\nb .S2 b3\nnop 5",
        interpreted,
        a4=0,
    )
    assert (after["a4"], after["a5"]) == (5, 6)
    assert after.counts.cycles == 6 + 1 + 6


def test_branches_in_delay_slots_each_land_in_turn(interpreted: bool) -> None:
    # One packet of `first` is issued before the second branch lands.
    after = run(
        "b .S1 first\nb .S1 second\nnop 4\n"
        "first:\nadd .L1 1,a4,a4\nadd .L1 16,a4,a4\nb .S2 b3\nnop 5\n"
        "second:\nadd .L1 2,a5,a5\nb .S2 b3\nnop 5",
        interpreted,
        a4=0,
        a5=0,
    )
    assert (after["a4"], after["a5"]) == (1, 2)


def test_a_branch_ends_a_multicycle_nop(interpreted: bool) -> None:
    after = run("b .S1 there\nnop 9\nthere:\nb .S2 b3\nnop 5", interpreted)
    assert after.counts.cycles == 6 + 6


@pytest.mark.parametrize("count", [1, 2, 9])
def test_nop_n_takes_n_cycles(count: int, interpreted: bool) -> None:
    assert run(f"nop {count}", interpreted).counts.cycles == count + 6


def test_bnop_waits_even_where_it_does_not_branch(interpreted: bool) -> None:
    text = "[a1] bnop .S1 there,5\nadd .L1 1,a4,a4\nb .S2 b3\nnop 5\nthere:\nb .S2 b3\nnop 5"
    taken, passed = run(text, interpreted, a1=1, a4=0), run(text, interpreted, a1=0, a4=0)
    assert (taken["a4"], taken.counts.cycles) == (0, 6 + 6)
    assert (passed["a4"], passed.counts.cycles) == (1, 6 + 1 + 6)


def test_a_call_returns_to_the_packet_behind_it(interpreted: bool) -> None:
    # What stands behind the call is not executed in its delay slots, only after the return: once.
    text = (
        "or .L1X 0,b3,a10\ncallp .S2 callee,b3\nadd .L1 1,a5,a5\nor .L2X 0,a10,b3\nb .S2 b3\nnop 5\n"
        "callee:\nb .S2 b3\nmvk .S1 40,a4\nnop 4"
    )
    after = run(text, interpreted)
    assert (after["a4"], after["a5"], after.counts.cycles) == (40, 1, 1 + 6 + 6 + 2 + 6)


def test_addkpc_gives_a_code_address_and_waits(interpreted: bool) -> None:
    after = run("addkpc .S2 here,b7,3\nhere:\nnop 1", interpreted)
    assert (after["b7"], after.counts.cycles) == (CODE + 4, 4 + 1 + 6)


def test_two_branches_that_land_together_are_refused(interpreted: bool) -> None:
    with pytest.raises(TargetError, match="two branches land in one cycle"):
        run("b .S1 there\n|| b .S2 there\nnop 5\nthere:\nnop 1", interpreted)


def interrupted(main: str, interpreted: bool, enabled: int = 1) -> After:
    """Run `main` with a vector of interrupt 4 that counts in b6 and keeps the return address in b7.

    The table of vectors begins at CODE; b11 holds the bit of interrupt 4. enabled: CSR.
    """
    lines = ["mvc .S2 b8,istp", "mvc .S2 b9,ier", "mvc .S2 b10,csr", *main.splitlines(), *RETURN.splitlines()]
    vector = ["add .L2 1,b6,b6", "b .S2 irp", "mvc .S2 irp,b7", "nop 4"]
    code = [line for line in lines if not line.endswith(":")]
    text = "\n".join([*lines, *["nop 1"] * (32 - len(code)), *vector])
    return run(text, interpreted, b8=CODE, b9=0x12, b10=enabled, b11=0x10)


def test_an_interrupt_runs_its_vector_once_and_returns_to_the_next_packet(interpreted: bool) -> None:
    after = interrupted("mvc .S2 b11,isr\nadd .L1 1,a5,a5\nmvc .S2 csr,b12", interpreted)
    # GIE is back, and what it was before stands in PGIE.
    assert (after["b6"], after["b7"], after["a5"], after["b12"]) == (1, CODE + 16, 1, 3)


def test_an_interrupt_waits_for_a_branch_to_land(interpreted: bool) -> None:
    main = "b .S2 there\nmvc .S2 b11,isr\nnop 4\nadd .L1 1,a6,a6\nthere:\nadd .L1 1,a5,a5"
    after = interrupted(main, interpreted)
    assert (after["b6"], after["b7"], after["a5"], after["a6"]) == (1, CODE + 28, 1, 0)


def test_an_interrupt_waits_for_the_global_enable(interpreted: bool) -> None:
    assert interrupted("mvc .S2 b11,isr\nadd .L1 1,a5,a5", interpreted, enabled=0)["b6"] == 0


def test_a_load_sees_memory_as_before_the_stores_of_its_packet(interpreted: bool) -> None:
    after = run(
        "stw .D1T1 a4,*+a8(0)\n|| ldw .D2T2 *+b8(0),b4\nldw .D1T1 *+a8(0),a5\nnop 4",
        interpreted,
        memory={DATA: 11},
        a4=22,
        a8=DATA,
        b8=DATA,
    )
    assert (after["b4"], after["a5"], after.word(DATA)) == (11, 22, 22)


@pytest.mark.parametrize(
    ("operand", "address", "base"),
    [
        ("*+a8(8)", 8, 0),
        ("*-a8(8)", -8, 0),
        ("*++a8(4)", 4, 4),
        ("*--a8(4)", -4, -4),
        ("*a8++(4)", 0, 4),
        ("*a8--(4)", 0, -4),
        ("*+a8[a7]", 12, 0),
        ("*a8++[a7]", 0, 12),
    ],
)
def test_addressing_modes(operand: str, address: int, base: int, interpreted: bool) -> None:
    middle = DATA + 64
    words = {middle + offset: 1000 + offset for offset in range(-16, 20, 4)}
    after = run(f"ldw .D1T1 {operand},a4\nor .S1 0,a8,a5\nnop 4", interpreted, memory=words, a7=3, a8=middle)
    assert after["a4"] == 1000 + address
    assert after["a5"] == middle + base  # a changed base is there in the next cycle


def test_accesses_that_need_not_be_aligned_count_in_bytes_or_elements(interpreted: bool) -> None:
    # Bytes 00 01 02 .. 27; (3) is three bytes on, [1] one element of eight bytes on.
    counted = {DATA + 4 * i: int.from_bytes(bytes(range(4 * i, 4 * i + 4)), "little") for i in range(10)}
    after = run(
        "ldndw .D1T1 *+a8(3),a11:a10\nldndw .D1T1 *+a8[1],a13:a12\nldndw .D1T1 *+a8[a7],a17:a16\n"
        "ldnw .D1T1 *+a8(5),a14\nnop 4\nstndw .D1T1 a11:a10,*+a8[3]\nstnw .D1T1 a14,*+a8(33)\n"
        "ldndw .D1T1 *++a8[2],a19:a18\nnop 4",
        interpreted,
        memory=counted,
        a7=2,
        a8=DATA,
    )
    assert (after["a10"], after["a11"]) == (0x0605_0403, 0x0A09_0807)
    assert (after["a12"], after["a13"]) == (0x0B0A_0908, 0x0F0E_0D0C)
    assert (after["a16"], after["a17"]) == (0x1312_1110, 0x1716_1514)
    assert after["a14"] == 0x0807_0605
    assert (after.word(DATA + 24), after.word(DATA + 28)) == (0x0605_0403, 0x0A09_0807)
    assert (after.word(DATA + 32), after.word(DATA + 36)) == (0x0706_0520, 0x2726_2508)
    assert (after["a8"], after["a18"], after["a19"]) == (DATA + 16, 0x1312_1110, 0x1716_1514)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("ldw .D1T1 *+a8(2),a4", "not a multiple of the size"),
        ("lddw .D1T1 *+a8(4),a5:a4", "not a multiple of the size"),
        ("ldw .D1T1 *+a9(0),a4", "outside the memory"),
        ("stw .D1T1 a4,*+a10(0)", "where code and constants lie"),
        ("b .S2 b7\nnop 5", "no execute packet starts here"),
        ("b .S1 inside\nnop 5\nnop 1\ninside:\n|| nop 1", "no execute packet starts here"),
        ("loop:\nb .S1 loop\nnop 5", "still running after 10000 cycles"),
        ("spint .L1 a11,a4", "a NaN becomes an integer"),
        ("rcpsp .S1 a4,a5", "not modelled"),
        ("sploop 4", "not modelled"),
        ("mvc .S2 b4,ilc", "not modelled"),
        ("mpydp .M1 a5:a4,a7:a6,a9:a8", "not modelled"),
        ("add .L1 a5:a4,a6,a9:a8", "not modelled"),
        ("extu .S1 a4,a5,a6", "not modelled"),
    ],
)
def test_what_is_forbidden_or_not_modelled_is_refused_by_name(text: str, complaint: str, interpreted: bool) -> None:
    with pytest.raises(TargetError, match=complaint) as refusal:
        run(text, interpreted, a8=DATA, a9=0x100, a10=CODE, a11=0x7FC0_0000, b7=DATA)
    assert "\n" not in str(refusal.value)


def test_what_is_not_modelled_matters_only_when_reached(interpreted: bool) -> None:
    assert run("mvk .S1 1,a4\nb .S2 b3\nnop 5\nrcpsp .S1 a4,a5", interpreted)["a4"] == 1


@pytest.mark.parametrize(
    ("packet", "complaint"),
    [
        ("or .L1 0,a4,a5\n|| or .L1 0,a6,a7", "unit L1 used 2 times"),
        ("ldw .D1T1 *+a8(0),a4\n|| stw .D2T1 a5,*+b8(0)", "data path T1 used 2 times"),
        ("ldnw .D1T1 *+a8(0),a4\n|| ldw .D2T2 *+b8(0),b4", "data path T2 used 2 times"),
        ("addsp .L1 a4,a4,a5\n|| addsp .S1 a4,a4,a6\n|| or .D1 0,a4,a7", "register read port of a4 used 5 times"),
        ("addsp .L1 a4,a4,a5\n|| addsp .S1 a4,a4,a6\n|| stw .D1T1 a4,*+a8(0)", "register read port of a4 used 5 times"),
        ("or .L1X 0,b4,a5\n|| or .S1X 0,b5,a6", "cross path 1X would have to carry b4 and b5"),
        ("or .L1X 0,b4,a5\n|| or .S1X 0,b4,a6\n|| or .D1X 0,b4,a7", "cross path 1X serves 3 units"),
        ("or .L1 0,b4,a5", "b4 is out of reach of unit L1"),
        ("or .L1X 0,b4,b5", "b5 is out of reach of unit L1"),
        ("ldw .D1T2 *+a8(0),a4", "data path T2 does not reach a4"),
        ("ldw .D1T1 *+b8(0),a4", "b8 is out of reach of unit D1"),
        ("bnop .S1 there,3\n|| nop 2\nthere:", "request idle cycles"),
        ("\n|| ".join(["nop 1"] * 9), "9 instructions in one packet"),
    ],
)
def test_a_packet_beyond_the_processors_resources_is_refused(packet: str, complaint: str, interpreted: bool) -> None:
    with pytest.raises(TargetError, match=complaint):
        run(packet, interpreted, a8=DATA, b8=DATA)


def test_full_use_of_the_resources_is_accepted(interpreted: bool) -> None:
    # Eight units, both data paths, both cross paths with one register for two units, four reads of a6 and of b4.
    after = run(
        "addsp .L1X a6,b4,a4\n|| subsp .S1X a6,b4,a5\n|| mpysp .M1 a10,a11,a7\n|| ldw .D1T1 *+a8(0),a9\n"
        "|| addsp .L2X b4,a6,b5\n|| or .S2X 0,a6,b6\n|| mpysp .M2 b10,b10,b7\n|| stw .D2T2 b4,*+b8(4)\nnop 4",
        interpreted,
        memory={DATA: 17},
        a6=bits(3.0),
        b4=bits(0.5),
        a8=DATA,
        b8=DATA,
        a10=bits(5.0),
        a11=bits(2.0),
        b10=bits(0.25),
    )
    floats = [after[name] for name in ("a4", "a5", "a7", "b5", "b6", "b7")]
    assert floats == [bits(value) for value in (3.5, 2.5, 10.0, 3.5, 3.0, 0.0625)]
    assert (after["a9"], after.word(DATA + 4)) == (17, bits(0.5))


@pytest.mark.parametrize(
    ("text", "stalls"),
    [
        ("mvk .S1 1,a4\nor .L2X 0,a4,b4", 1),
        ("mvk .S1 1,a4\nnop 1\nor .L2X 0,a4,b4", 0),
        ("mvk .S1 1,a4\nor .L1 0,a4,a5", 0),
        ("addsp .L1 a6,a7,a4\nnop 3\nor .L2X 0,a4,b4", 1),
        ("ldw .D1T1 *+a8(0),a4\nnop 4\nor .L2X 0,a4,b4", 0),
    ],
)
def test_waits_of_the_cross_paths_are_counted_beside_the_cycles(text: str, stalls: int, interpreted: bool) -> None:
    # A register read over a cross path in the cycle after it was written costs one cycle, unless a load wrote it.
    with_nops = run(text, interpreted, a8=DATA)
    assert with_nops.counts.stalls == stalls
    cycles = sum(int(line.split()[1]) if line.startswith("nop") else 1 for line in text.splitlines())
    assert with_nops.counts.cycles == cycles + 6


def test_the_deepest_stack_is_remembered(interpreted: bool) -> None:
    after = run("addk .S2 -96,b15\nnop 1\naddk .S2 96,b15", interpreted, b15=DATA + 512)
    assert (after.counts.lowest_stack_pointer, after["b15"]) == (DATA + 416, DATA + 512)
