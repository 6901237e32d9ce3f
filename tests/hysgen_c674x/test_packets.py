"""The interpreter and the compiled engine keep every rule of the pipeline."""

from __future__ import annotations

import pytest

from fixtures.c674x_packets import CODE
from fixtures.c674x_rules import RULES
from hysgen_c674x.assembly import instructions
from hysgen_c674x.packets import packets


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
@pytest.mark.parametrize("rule", RULES)
def test_the_simulator_keeps_the_rule(rule: str, interpreted: bool) -> None:
    RULES[rule](interpreted)


def test_bars_join_neighbours_only() -> None:
    # Code that ends one section and a bar that starts another are not one packet.
    apart = f"{CODE:x}:\t00000000 \tnop 1\n{CODE + 64:x}:\t00000000 \t|| mvk .S1 1,a4"
    found = packets(instructions(apart))
    assert [len(packet.instructions) for packet in found.values()] == [1, 1]
    assert "parallel to nothing" in str(found[CODE + 64].refusal)
