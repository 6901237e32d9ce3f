"""What the instructions of each cycle occupy: units, the two cross paths, the two data paths, register ports.

Source: SPRUFE8, chapters 2 and 3.8.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from hysgen_c674x.schedule.instructions import Node
from hysgen_c674x.schedule.placement import Placement, Register

_READS: Final = 4
"""Readings of one register in one cycle."""

_READERS: Final = 2
"""Instructions that share what a cross path carries."""


@dataclass
class Occupancy:
    """Occupied parts of the machine, by cycle.

    units: of a cycle. ports: (unit, cycle in which it writes). paths: (cycle, data path of a load or store). reads: by
    cycle and register. crossing, crossed: by cycle and side, the register that a cross path carries and its readers.
    """

    units: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    ports: set[tuple[str, int]] = field(default_factory=set)
    paths: set[tuple[int, int]] = field(default_factory=set)
    reads: Counter[tuple[int, int, int]] = field(default_factory=Counter)
    crossing: dict[tuple[int, int], Register] = field(default_factory=dict)
    crossed: Counter[tuple[int, int]] = field(default_factory=Counter)

    def unit(self, node: Node, kinds: str, cycle: int, side: int, taken: Iterable[str] = ()) -> str | None:
        """A free unit of one of the kinds, whose result has a write port; taken: units that are spoken for."""
        for kind in kinds:
            unit = f"{kind}{side + 1}"
            if unit in self.units[cycle] or unit in taken:
                continue
            if kind != "D" and (unit, cycle + node.delay) in self.ports:
                continue
            return unit
        return None

    def exhausted(self, node: Node, cycle: int) -> bool:
        """Whether no unit is left in a cycle for instructions of this kind."""
        sides = (0, 1) if node.side is None or node.memory else (node.side,)
        return not any(self.unit(node, node.units, cycle, side) for side in sides)

    def cross_free(self, cycle: int, side: int, register: Register) -> bool:
        """Whether the cross path to a side can carry a register."""
        carried = self.crossing.get((cycle, side))
        return carried is None or (carried == register and self.crossed[cycle, side] < _READERS)

    def readable(self, cycle: int, operands: Iterable[Register | int]) -> bool:
        """Whether the registers among the operands have a read port each."""
        wanted = [register for register in operands if not isinstance(register, int)]
        return all(self.reads[cycle, *register] + wanted.count(register) <= _READS for register in wanted)

    def occupy(self, placement: Placement) -> None:
        """Enter the units, cross paths and ports of an instruction; a data path is entered by `carry`."""
        node, cycle, side = placement.node, placement.cycle, placement.side
        for unit, _, operand, cross in placement.moves:
            self._write(unit, cycle)
            self._read(cycle, side, [operand], [operand] if cross else [])
        if placement.moves:
            return
        if node.memory:
            self.units[cycle].add(placement.unit)
        else:
            self._write(placement.unit, cycle, node.delay)
        far = [each for each in placement.operands if not isinstance(each, int) and each[0] != side]
        self._read(cycle, side, placement.operands, [] if node.memory else far)

    def carry(self, cycle: int, path: int) -> None:
        """Enter the data path of a load or store."""
        self.paths.add((cycle, path))

    def _write(self, unit: str, cycle: int, delay: int = 0) -> None:
        self.units[cycle].add(unit)
        self.ports.add((unit, cycle + delay))

    def _read(
        self, cycle: int, side: int, operands: Iterable[Register | int], crossing: Iterable[Register | int]
    ) -> None:
        for register in crossing:
            assert not isinstance(register, int)
            self.crossing[cycle, side] = register
            self.crossed[cycle, side] += 1
        for register in operands:
            if not isinstance(register, int):
                self.reads[cycle, *register] += 1
