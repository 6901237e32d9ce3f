"""List scheduling: a cycle, a unit and a register for every instruction of a kernel.

Cycle by cycle, the instructions whose operands are ready are placed by the longest latency that follows them. Units,
the two cross paths, the two data paths, register read ports and write ports are tracked. A register is taken when an
instruction is issued and returned when the last reader is, so at most one result for it is in flight: an interrupt
between any two packets, after which all results have arrived, changes nothing. A register that was written in the
cycle before is not read over a cross path, which would stall.

A plan uses the registers that a function may change (A0-A9, A16-A31, B0-B2, B4-B9, B16-B31), or all but B3 and B15 with
a stack frame (`frame`).
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from hysgen.c674x.schedule import frame
from hysgen.c674x.schedule.frame import FrameInstruction, Pair
from hysgen.c674x.schedule.instructions import LOAD_DELAY, MIRRORED, UNITS, Both, Node, Operand, Selected, nodes_of
from hysgen.errors import TargetError

PREDICATES: Final = ((0, 1, 2), (0, 1, 2))
GENERAL: Final = ((*range(3, 10), *range(16, 32)), (*range(4, 10), *range(16, 32)))
PRESERVED: Final = (tuple(range(10, 16)), tuple(range(10, 15)))
BRANCH_SLOTS: Final = 5
_PACKET: Final = 8
_READS: Final = 4
_URGENT: Final = 8
"""Oldest instructions, in the order of the C text, for which registers are reserved."""

_YOUNGER: Final = 2
"""Conditions in registers that stand behind a condition without a register, in the order of the instructions."""

_CHECKED: Final = 4
"""Cycles between two comparisons of an attempt with the shortest schedule known, which take time."""

_STACK_READY: Final = 2
"""Cycle from which the new stack pointer can be read, over a cross path too."""

_STUCK: Final = 2
"""Cycles without an instruction after which an operand of the oldest one is moved to the other side."""

_PATIENCE: Final = 16
"""Cycles without an instruction after which a schedule has run out of registers."""


class OutOfRegistersError(TargetError):
    """No instruction can be placed, for want of registers."""


class TooLongError(TargetError):
    """A shorter schedule is known already."""


@dataclass(frozen=True)
class Placement:
    """Where one instruction is: cycle, unit, side of unit and register; cross: whether an operand crosses.

    moves: of a select, the predicated moves as (unit, when zero, operand, cross).
    """

    node: Node
    cycle: int
    unit: str
    side: int
    data_side: int
    register: int | None
    operands: tuple[tuple[int, int] | int, ...]
    cross: bool
    guard: tuple[int, int] | None
    moves: tuple[tuple[str, bool, tuple[int, int] | int, bool], ...] = ()


@dataclass(frozen=True)
class Schedule:
    """All placements in the order of their cycles, the cycle of the return branch, and the cycles of a call."""

    placements: Sequence[Placement]
    branch: int
    cycles: int
    frame: Sequence[FrameInstruction] = ()


@dataclass(frozen=True)
class Plan:
    """Settings of one attempt.

    window: instructions in the order of the C text among which to choose. lead: cycles that loads and constants may
    come before their first use needs them. reserve: registers of a side that only the oldest instructions may take.
    For the instructions of `spilling`: taper: registers of a side that an instruction must leave free, for each
    instruction between the oldest one and it; ahead: window of loads and constants.
    """

    window: int
    lead: int
    reserve: int
    slope: float
    stretch: float = 0.0
    saved: bool = False
    taper: float = 0.0
    ahead: int = 1 << 30


def unlimited(selected: Selected, window: int = 1 << 30, slope: float = 0.0) -> dict[int, int]:
    """The cycle of every instruction, by its id, if there were as many registers as one likes.

    window, slope: of the plan.
    """
    attempt = _List(selected, Plan(window, 0, 0, slope), None, unlimited=True)
    attempt.run()
    return {key: placement.cycle for key, placement in attempt.placed.items()}


def planned(selected: Selected, plan: Plan, issue: Mapping[int, int] | None, below: int = 1 << 30) -> Schedule:
    """The schedule of one plan; issue: the cycles of `unlimited`, None if loads and constants are in their places.

    Instructions from `spilling` are changed: each list of them serves for one call.

    Raises OutOfRegistersError, and TooLongError if the schedule would take `below` cycles or more.
    """
    return _List(selected, plan, issue, below=below).run()


def heights(nodes: Sequence[Node]) -> dict[int, int]:
    """Cycles from the issue of each instruction to the end of the longest chain that follows it."""
    height: dict[int, int] = {}
    for node in reversed(nodes):
        mine = height.setdefault(id(node), node.delay + 1 if node.writes else 1)
        if node.second is not None:
            mine = height[id(node)] = max(mine, height.get(id(node.second), 0))
        for value in node.values():
            for each in nodes_of(value):
                height[id(each)] = max(height.get(id(each), 0), each.delay + 1 + mine)
        for earlier, cycles in node.before:
            height[id(earlier)] = max(height.get(id(earlier), 0), cycles + mine)
    return height


@dataclass
class _List:
    """One attempt. issue: cycles of an attempt without limits on registers, for the release of loads and constants."""

    selected: Selected
    plan: Plan
    issue: Mapping[int, int] | None
    unlimited: bool = False
    below: int = 1 << 30
    placed: dict[int, Placement] = field(default_factory=dict)
    result: list[Placement] = field(default_factory=list)
    uses: Counter[int] = field(default_factory=Counter)
    free: list[set[int]] = field(default_factory=list)
    units: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    crossing: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    crossed: Counter[tuple[int, int]] = field(default_factory=Counter)
    ports: set[tuple[str, int]] = field(default_factory=set)
    paths: set[tuple[int, int]] = field(default_factory=set)
    reads: Counter[tuple[int, int, int]] = field(default_factory=Counter)
    extra: int = 100
    waiting: Counter[int] = field(default_factory=Counter)
    followers: dict[int, list[tuple[Node, int]]] = field(default_factory=lambda: defaultdict(list))
    ready_at: dict[int, int] = field(default_factory=dict)
    pending: list[tuple[int, float, Node]] = field(default_factory=list)  # ready cycle, position, instruction
    height: dict[int, int] = field(default_factory=dict)
    left: int = 0
    reserved: dict[int, tuple[int, int]] = field(default_factory=dict)
    urgent: set[int] = field(default_factory=set)

    def run(self) -> Schedule:
        nodes = self.selected.nodes
        self.height = heights(nodes)
        self.consumers: dict[int, list[Node]] = defaultdict(list)
        end = self.plan.stretch * max(self.height.values(), default=0)
        self.due = {id(node): end - self.height[id(node)] - self.plan.lead for node in nodes}
        for node in nodes:
            for value in node.values():
                for each in nodes_of(value):
                    self.uses[id(each)] += 1
                    self.consumers[id(each)].append(node)
                    self.followers[id(each)].append((node, each.delay + 1))
                    self.waiting[id(node)] += 1
            for earlier, cycles in node.before:
                self.followers[id(earlier)].append((node, cycles))
                self.waiting[id(node)] += 1
        self.free = [{*PREDICATES[s], *GENERAL[s]} for s in (0, 1)]
        tests = any(node.predicate for node in nodes)
        self.general = [GENERAL[s] if tests else (*PREDICATES[s], *GENERAL[s]) for s in (0, 1)]
        self.frame: list[FrameInstruction] = []
        if self.plan.saved:
            self.general = [(*self.general[s], *PRESERVED[s]) for s in (0, 1)]
            self._open()
        by_order = sorted(nodes, key=lambda node: node.order)
        position: dict[int, float] = {id(node): k for k, node in enumerate(by_order)}
        self.position = position
        self.conditions = deque(node for node in by_order if node.predicate)
        self.testable: list[int] = []
        self.moves: list[Node] = []
        self.ready_at = {id(node): self._release(node) for node in nodes}
        for parameter in self.selected.parameters:
            assert parameter.side is not None
            assert parameter.register is not None
            self.placed[id(parameter)] = Placement(
                parameter, -9, "", parameter.side, parameter.side, parameter.register, (), False, None
            )
            if self.uses[id(parameter)]:
                self.free[parameter.side].discard(parameter.register)
            for follower, _ in self.followers[id(parameter)]:
                self.waiting[id(follower)] -= 1
        for node in nodes:
            if any(each.register == 15 for value in node.values() for each in nodes_of(value)):
                self.ready_at[id(node)] = _STACK_READY
        for node in nodes:
            if not self.waiting[id(node)]:
                heapq.heappush(self.pending, (self.ready_at[id(node)], position[id(node)], node))
        cycle, idle = 0, 0
        self.left = len(nodes)
        oldest = 0
        slope = self.plan.slope
        ready: list[tuple[float, float, int, Node]] = []  # by height and position; arrivals keep their order
        arrivals = 0
        while self.left:
            if cycle + 1 >= self.below:
                raise TooLongError("a shorter schedule is known")
            if self.plan.saved:
                self._saved(cycle)
            while self.pending and self.pending[0][0] <= cycle:
                node = heapq.heappop(self.pending)[2]
                arrivals += 1
                ready.append((slope * position[id(node)] - self.height[id(node)], position[id(node)], arrivals, node))
            while oldest < len(by_order) and id(by_order[oldest]) in self.placed:
                oldest += 1
            limit = oldest + self.plan.window
            self.oldest = oldest
            self.urgent = {id(node) for node in by_order[oldest : oldest + _URGENT]}
            if cycle % _CHECKED == 0 and any(cycle + self.height[id(each[-1])] >= self.below for each in ready):
                raise TooLongError("a shorter schedule is known")
            ready.sort()
            kept: list[tuple[float, float, int, Node]] = []
            issued = sum(each.cycle == cycle for each in self.frame)
            exhausted: set[tuple[str, int, int | None]] = set()
            for k, entry in enumerate(ready):
                if issued >= _PACKET:
                    kept += ready[k:]
                    break
                node = entry[-1]
                kind = node.units, node.delay, node.side
                placement = None
                if kind not in exhausted and entry[1] < (oldest + self.plan.ahead if node.source else limit):
                    placement = self._place(node, cycle)
                    if placement is None and self._exhausted(node, cycle):
                        exhausted.add(kind)
                if placement is None:
                    kept.append(entry)
                    continue
                issued += max(1, len(placement.moves))
                self.left -= 1
                released = list(self.followers[id(node)])
                if node.second is not None:
                    released += self.followers[id(node.second)]
                for follower, cycles in released:
                    self.waiting[id(follower)] -= 1
                    self.ready_at[id(follower)] = max(self.ready_at[id(follower)], cycle + cycles)
                    if not self.waiting[id(follower)]:
                        heapq.heappush(self.pending, (self.ready_at[id(follower)], position[id(follower)], follower))
            ready = kept
            idle = 0 if issued or cycle < 4 else idle + 1
            if idle > _STUCK and self.plan.taper and ready and not self.pending:
                moved = self._moved(min(ready, key=lambda each: each[1])[-1])
                if moved is not None:
                    move, node = moved
                    self._enter(move, node, -0.25, cycle)
                    self.height[id(move)] += 1
                    self.followers[id(move)].append((node, 1))
                    self.waiting[id(node)] += 1
                    ready = [each for each in ready if each[-1] is not node]
                    arrivals += 1
                    ready.append(
                        (slope * position[id(move)] - self.height[id(move)], position[id(move)], arrivals, move)
                    )
                    idle = 0
            if idle > _PATIENCE and not (self.pending and self.pending[0][0] > cycle):
                raise OutOfRegistersError("out of registers")
            cycle += 1
        return self._finished()

    def _open(self) -> None:
        """Take the units and registers that open the stack frame."""
        self.frame = frame.entry(self.selected.stack)
        for each in self.frame:
            self.units[each.cycle].add(each.unit)
            if each.path is None:
                self.ports.add((each.unit, each.cycle))
            else:
                self.paths.add((each.cycle, each.path))
        self.crossing[0, 0], self.crossed[0, 0] = (1, 15), 2
        side, register = frame.POINTER
        self.free[side].discard(register)

    def _saved(self, cycle: int) -> None:
        """Return the registers that the stores of this cycle have saved."""
        for pair in frame.PAIRS:
            if frame.saved_at(pair, self.selected.stack) == cycle:
                self.free[pair.side] |= set(pair.registers)
        if cycle == self._all_saved():
            self.free[frame.POINTER[0]].add(frame.POINTER[1])

    def _release(self, node: Node) -> int:
        """Earliest cycle of a load or constant: a few cycles before its first use in an attempt without limits."""
        if self.issue is None or not node.source or self.plan.stretch:
            return 0
        return max(0, self._needed(node) - node.delay - 1 - self.plan.lead)

    def _needed(self, node: Node) -> int:
        """The cycle in which the first instruction that uses a value, or a source made from it, was issued."""
        assert self.issue is not None
        first = 1 << 30
        for user in self.consumers[id(node)]:
            first = min(first, self._needed(user) - user.delay - 1 if user.source else self.issue[id(user)])
        return first if first < 1 << 30 else 0

    # ---- one instruction

    def _place(self, node: Node, cycle: int) -> Placement | None:
        sides: tuple[int, ...]
        if node.in_place:
            (source,) = node.operands
            assert isinstance(source, Node)
            sides = (self.placed[id(source)].data_side,)
        else:
            sides = (node.side,) if node.side is not None else self._preferred(node)
            if id(node) in self.reserved:
                sides = (self.reserved[id(node)][0],)
        for side in sides:
            found = self._memory(node, cycle, side) if node.memory else self._select(node, cycle, side)
            if found is not None:
                return found
        return None

    def _preferred(self, node: Node) -> tuple[int, int]:
        """The sides, the better first: few crossing operands, near the partners of the users, with free registers."""
        cost = [0.0, 0.0]
        for operand in node.operands:
            if isinstance(operand, Node):
                cost[1 - self.placed[id(operand)].data_side] += 3.0
        for user in self.consumers[id(node)][:4]:
            if user.side is not None:
                cost[1 - user.side] += 2.0
            for partner in user.operands:
                if isinstance(partner, Node) and partner is not node and id(partner) in self.placed:
                    cost[1 - self.placed[id(partner)].data_side] += 2.0
        for side in (0, 1):
            cost[side] += 0.08 * (23 - len(self.free[side]))
        return (0, 1) if cost[0] <= cost[1] else (1, 0)

    def _operand(self, operand: Operand, side: int) -> tuple[int, int] | int:
        if isinstance(operand, int):
            return operand
        node = operand.sides[side] if isinstance(operand, Both) else operand
        placement = self.placed[id(node)]
        assert placement.register is not None
        return placement.data_side, placement.register

    def _source(self, operand: Operand, side: int) -> Node | None:
        if isinstance(operand, int):
            return None
        return operand.sides[side] if isinstance(operand, Both) else operand

    def _crossable(self, node: Node, cycle: int) -> bool:
        """Whether a value may be read over a cross path in a cycle without a stall."""
        placement = self.placed[id(node)]
        return node.load or node.mnemonic == "param" or cycle > placement.cycle + node.delay + 1

    def _cross_free(self, cycle: int, side: int, register: tuple[int, int]) -> bool:
        carried = self.crossing.get((cycle, side))
        return carried is None or (carried == register and self.crossed[cycle, side] < 2)

    def _readable(self, cycle: int, registers: Iterable[tuple[int, int] | int]) -> bool:
        wanted = [register for register in registers if not isinstance(register, int)]
        return all(self.reads[cycle, *register] + wanted.count(register) <= _READS for register in wanted)

    def _unit(self, node: Node, kinds: str, cycle: int, side: int, taken: Iterable[str] = ()) -> str | None:
        for kind in kinds:
            unit = f"{kind}{side + 1}"
            if unit in self.units[cycle] or unit in taken:
                continue
            if kind != "D" and (unit, cycle + node.delay) in self.ports:
                continue
            return unit
        return None

    def _exhausted(self, node: Node, cycle: int) -> bool:
        """Whether no unit is left in a cycle for instructions of this kind."""
        sides = (0, 1) if node.side is None or node.memory else (node.side,)
        return not any(self._unit(node, node.units, cycle, side) for side in sides)

    def _select(self, node: Node, cycle: int, side: int) -> Placement | None:
        if node.mnemonic == "select":
            return self._moves(node, cycle, side)
        operands = list(node.operands)
        own = [self._operand(operand, side) for operand in operands]
        crossing = [k for k, operand in enumerate(own) if not isinstance(operand, int) and operand[0] != side]
        kinds = node.units
        if crossing:
            if len({own[k] for k in crossing}) > 1 or len(crossing) > 1:
                return None
            (k,) = crossing
            source = self._source(operands[k], side)
            carried = own[k]
            assert source is not None
            assert not isinstance(carried, int)
            if (
                node.mnemonic == "clr"
                or not self._crossable(source, cycle)
                or not self._cross_free(cycle, side, carried)
            ):
                return None
            if k == 0 and len(operands) > 1 and not isinstance(own[1], int):
                if node.mnemonic == "sub" or node.mnemonic == "subsp":
                    kinds = kinds.replace("D", "")
                elif node.mnemonic in _SWAPPED:
                    own.reverse()
                    operands.reverse()
                else:
                    return None
        unit = self._unit(node, kinds, cycle, side)
        if unit is None or not self._readable(cycle, own):
            return None
        mnemonic = node.mnemonic
        swapped = operands != node.operands
        register = self._register(node, cycle, side, operands)
        if register is None:
            return None
        placement = Placement(node, cycle, unit, side, side, register, tuple(own), bool(crossing), None)
        if swapped and mnemonic in MIRRORED:
            placement = Placement(_mirrored(node), cycle, unit, side, side, register, tuple(own), True, None)
        self._commit(node, placement, [self._source(operand, side) for operand in operands])
        return placement

    def _memory(self, node: Node, cycle: int, preferred: int) -> Placement | None:
        """A load to, or a store from, the preferred side, by the unit of either side."""
        store = not node.writes
        value = self._source(node.operands[1], preferred) if store else None
        data = self.placed[id(value)].data_side if value is not None else preferred
        if (cycle, data) in self.paths:
            return None
        guard: tuple[int, int] | None = None
        if node.guard is not None:
            tested = self._operand(node.guard, 0)
            assert not isinstance(tested, int)
            guard = tested
        for side in (data, 1 - data):
            base = node.operands[0]
            own = self._operand(base, side)
            unit = f"D{side + 1}"
            assert not isinstance(own, int)
            if own[0] != side or unit in self.units[cycle]:
                continue
            operands: list[tuple[int, int] | int] = [own]
            sources = [self._source(base, side), value, node.guard]
            if value is not None:
                operands.append(self._operand(value, data))
            if node.mnemonic == "stdw":
                sources.append(self._source(node.operands[2], data))
                operands.append(self._operand(node.operands[2], data))
            if not self._readable(cycle, operands):
                continue
            register = None
            if not store:
                register = self._pair(node, data) if node.second else self._register(node, cycle, data, [])
            if register is None and not store:
                return None
            self.paths.add((cycle, data))
            placement = Placement(node, cycle, unit, side, data, register, tuple(operands), False, guard)
            other = base.sides[1 - side] if isinstance(base, Both) else None
            self._commit(node, placement, [*sources, other])
            if node.second is not None:
                assert register is not None
                self.placed[id(node.second)] = replace(placement, node=node.second, register=register + 1)
                self.free[data].discard(register + 1)
            return placement
        return None

    def _moves(self, node: Node, cycle: int, side: int) -> Placement | None:
        """A choice as one predicated move onto the other operand, or as two moves to a register of its own."""
        condition, *choices = node.operands
        guard = self._operand(condition, side)
        assert not isinstance(guard, int)
        own = [self._operand(choice, side) for choice in choices]
        sources = [self._source(choice, side) for choice in choices]
        target: int | None = None
        keep: int | None = None
        for k in (1, 0):
            source = sources[k]
            if source is None or own[k] == guard:
                continue
            placement = self.placed[id(source)]
            if (
                placement.data_side == side
                and self.uses[id(source)] == 1
                and source.mnemonic != "param"
                and node.pair is None
                and not self._misplaced(node, placement.register)
            ):
                target, keep = placement.register, k
                break
        moving = [k for k in (0, 1) if k != keep]
        taken: list[str] = []
        moves: list[tuple[str, bool, tuple[int, int] | int, bool]] = []
        crossing: tuple[int, int] | None = None
        for k in moving:
            operand = own[k]
            cross = not isinstance(operand, int) and operand[0] != side
            if cross:
                source = sources[k]
                assert source is not None
                assert not isinstance(operand, int)
                if not self._crossable(source, cycle) or not self._cross_free(cycle, side, operand):
                    return None
                if crossing is not None and (crossing != operand or self.crossed[cycle, side]):
                    return None
                crossing = operand
            unit = self._unit(node, "DLS", cycle, side, taken)
            if unit is None:
                return None
            taken.append(unit)
            moves.append((unit, k == 1, operand, cross))
        if not self._readable(cycle, [own[k] for k in moving]):
            return None
        if target is None:
            target = self._register(node, cycle, side, [])
            if target is None:
                return None
        else:
            self.uses[id(sources[keep])] = -1  # type: ignore[index]
        placement = Placement(node, cycle, taken[0], side, side, target, (), False, guard, tuple(moves))
        self._commit(node, placement, [self._source(condition, side), *(s for k, s in enumerate(sources) if k != keep)])
        return placement

    def _misplaced(self, node: Node, register: int | None) -> bool:
        """Whether the result must be testable and the register is not."""
        return node.predicate and register not in PREDICATES[0]

    def _register(self, node: Node, cycle: int, side: int, operands: Sequence[Operand]) -> int | None:
        """Take a register for the result; None if there is none."""
        if node.in_place:
            source = self._source(operands[0], side)
            return self.placed[id(source)].register
        free = self.free[side]
        dying = set()
        sources = [source for operand in operands if (source := self._source(operand, side)) is not None]
        for source in sources:
            if self.uses[id(source)] == sum(each is source for each in sources):
                placement = self.placed[id(source)]
                if placement.data_side == side and placement.register is not None and placement.register < 32:
                    dying.add(placement.register)
        if node.pair is not None and not self.unlimited:
            return self._paired(node, side, free, dying)
        if node.register is not None:
            return node.register if node.register in free | dying else None
        if self.plan.stretch and not dying and cycle < self.due[id(node)] and id(node) not in self.urgent:
            return None
        if node.predicate:
            if self.plan.taper and not self._orderly(node):
                return None
            choice = [r for r in PREDICATES[side] if r in free or r in dying]
        else:
            choice = [r for r in self.general[side] if r in free or r in dying]
        if not choice and id(node) in self.urgent and not node.predicate:
            spare = [r for r in PREDICATES[side] if r in free]
            choice = spare[1:]
        if choice and not self.unlimited:
            reserve = 1 if node.predicate else self.plan.reserve
            if self.plan.taper:
                distance = self.position[id(node)] - self.oldest
                reserve = 0 if node.predicate else int(self.plan.taper * distance)
            if id(node) in self.urgent or dying:
                reserve = 0
            if self.plan.taper:
                choice.sort(key=lambda r: r not in dying and r ^ 1 in free)
            return choice[0] if len(choice) > reserve else None
        if self.unlimited:
            self.extra += 1
            return self.extra
        return None

    def _paired(self, node: Node, side: int, free: set[int], dying: set[int]) -> int | None:
        """A register for a value of a 64-bit store; its neighbour is kept for the other value."""
        assert node.pair is not None
        if id(node) in self.reserved:
            reserved_side, register = self.reserved[id(node)]
            return register if reserved_side == side else None
        other, odd = node.pair
        urgent = id(node) in self.urgent
        general = [r for r in self.general[side] if r in free]
        reserve = 0 if urgent else int(self.plan.taper * (self.position[id(node)] - self.oldest))
        for register in self.general[side]:
            if (
                register % 2 == odd
                and register in free | dying
                and register ^ 1 in general
                and len(general) >= reserve + 2
            ):
                chosen: int = register
                self.reserved[id(other)] = side, chosen ^ 1
                free.discard(chosen ^ 1)
                return chosen
        self._split_store(node, other)
        return None

    def _split_store(self, one: Node, other: Node) -> None:
        """Two stores in the place of a 64-bit store for whose values there are no neighbouring registers."""
        one.pair = other.pair = None
        stores = [user for each in (one, other) for user in self._users(each) if user.mnemonic == "stdw"]
        for store in {id(each): each for each in stores}.values():
            base, low, high = store.operands
            assert isinstance(high, Node)
            store.mnemonic, store.operands = "stw", [base, low]
            second = replace(store, operands=[base, high], number=store.number + 4, before=list(store.before))
            self._enter(second, store, 0.5, 0)
            self.followers[id(second)] = list(self.followers[id(store)])
            for follower, _ in self.followers[id(store)]:
                self.waiting[id(follower)] += 1
            self.followers[id(high)] = [
                (second if user is store else user, cycles) for user, cycles in self.followers[id(high)]
            ]
            self.consumers[id(high)] = [second if user is store else user for user in self.consumers[id(high)]]
            if id(high) not in self.placed:
                self.waiting[id(store)] -= 1
                self.waiting[id(second)] += 1
            else:
                self.ready_at[id(second)] = self.placed[id(high)].cycle + high.delay + 1
            for value in (*nodes_of(base), *([store.guard] if store.guard else [])):  # type: ignore[arg-type]
                self.uses[id(value)] += 1
                self.consumers[id(value)].append(second)
                self._wait(second, value, value.delay + 1)
            for earlier, cycles in store.before:
                self._wait(second, earlier, cycles)
            for each in (store, second):
                if not self.waiting[id(each)] and (each is second or id(high) not in self.placed):
                    heapq.heappush(self.pending, (self.ready_at[id(each)], self.position[id(each)], each))

    def _enter(self, new: Node, like: Node, distance: float, ready_at: int) -> None:
        """Take up an instruction that this attempt has made, at a distance in the order from one that it is like."""
        self.position[id(new)] = self.position[id(like)] + distance
        self.height[id(new)], self.due[id(new)] = self.height[id(like)], self.due[id(like)]
        self.ready_at[id(new)] = ready_at
        self.left += 1

    def _wait(self, node: Node, earlier: Node, cycles: int) -> None:
        if id(earlier) in self.placed:
            self.ready_at[id(node)] = max(self.ready_at[id(node)], self.placed[id(earlier)].cycle + cycles)
        else:
            self.followers[id(earlier)].append((node, cycles))
            self.waiting[id(node)] += 1

    def _users(self, node: Node) -> list[Node]:
        """The users of a value; of the lower half of a constant, those of the constant."""
        return [user for each in self.consumers[id(node)] for user in (self._users(each) if each.in_place else [each])]

    def _pair(self, node: Node, side: int) -> int | None:
        """The even one of two neighbouring registers for the words of a 64-bit load."""
        if self.unlimited:
            self.extra += 2
            return self.extra & ~1
        free = [r for r in self.general[side] if r in self.free[side]]
        reserve = 0 if id(node) in self.urgent else int(self.plan.taper * (self.position[id(node)] - self.oldest))
        chosen: int | None = (
            next((r for r in free if r % 2 == 0 and r + 1 in free), None) if len(free) >= reserve + 2 else None
        )
        if chosen is None and id(node) in self.urgent:
            self._split_load(node)
        return chosen

    def _split_load(self, node: Node) -> None:
        """Two loads in the place of a 64-bit load for which there are no neighbouring registers."""
        second, base = node.second, node.operands[0]
        assert second is not None
        assert not isinstance(base, int)
        node.mnemonic, node.second = "ldw", None
        second.mnemonic, second.units, second.operands, second.number = "ldw", "D", [base], node.number + 4
        self._enter(second, node, 0.5, self.ready_at[id(node)])
        for value in nodes_of(base):
            self.uses[id(value)] += 1
            self.consumers[id(value)].append(second)
        heapq.heappush(self.pending, (self.ready_at[id(second)], self.position[id(second)], second))
        if any(user.mnemonic == "stdw" for user in self._users(node)):
            self._split_store(node, second)

    def _moved(self, node: Node) -> tuple[Node, Node] | None:
        """A move of an operand to the other side, where there is a register for the result of a stuck instruction."""
        operands = [each for each in node.operands if isinstance(each, Node)]
        kinds = PREDICATES if node.predicate else self.general
        for side in (0, 1):
            far = [each for each in operands if self.placed[id(each)].data_side != side]
            free = [r for r in kinds[side] if r in self.free[side]]
            fitting = len(free) >= (1 if node.predicate else 2)
            if id(node) in self.reserved:
                fitting = bool(free) and self.reserved[id(node)][0] == side
            if len(far) < 2 or not fitting or node.mnemonic == "select":
                continue
            move = Node("mv", [far[0]], *UNITS["mv"], node.order, side=side)
            node.operands[node.operands.index(far[0])] = move
            self.consumers[id(far[0])].remove(node)
            self.consumers[id(far[0])].append(move)
            self.consumers[id(move)].append(node)
            self.uses[id(move)] = 1
            self.moves.append(move)
            return move, node
        return None

    def _orderly(self, node: Node) -> bool:
        """Whether a condition may take one of the six registers before the conditions in front of it."""
        while self.conditions and id(self.conditions[0]) in self.placed:
            self.conditions.popleft()
        first = self.position[id(self.conditions[0])]
        younger = sum(1 for key in self.testable if self.uses[key] > 0 and self.position[key] > first)
        return node is self.conditions[0] or younger < _YOUNGER

    def _commit(self, node: Node, placement: Placement, sources: Iterable[Node | None]) -> None:
        cycle, side = placement.cycle, placement.side
        self.placed[id(node)] = placement
        self.result.append(placement)
        if node.predicate:
            self.testable.append(id(node))
        if placement.moves:
            for unit, _, operand, cross in placement.moves:
                self._occupy(unit, cycle, 0)
                self._cross(cycle, side, [operand] if cross else [])
                self._count_reads(cycle, [operand])
        else:
            self._occupy(placement.unit, cycle, node.delay if not node.memory else -1)
            crossing = [o for o in placement.operands if not isinstance(o, int) and o[0] != side]
            self._cross(cycle, side, crossing if not node.memory else [])
            self._count_reads(cycle, placement.operands)
        for source in sources:
            if source is None:
                continue
            self.uses[id(source)] -= 1
            if not self.uses[id(source)]:
                self._return(source)
        for each in node.operands:
            if isinstance(each, Both) and not node.memory:
                other = each.sides[1 - side]
                self.uses[id(other)] -= 1
                if not self.uses[id(other)]:
                    self._return(other)
        if placement.register is not None:
            self.free[placement.data_side].discard(placement.register)
        if node.memory and node.mnemonic == "stw" and isinstance(node.operands[1], Both):
            other = node.operands[1].sides[1 - placement.data_side]
            self.uses[id(other)] -= 1
            if not self.uses[id(other)]:
                self._return(other)

    def _return(self, source: Node) -> None:
        placement = self.placed[id(source)]
        register = placement.register
        if register is not None and register < 32:
            self.free[placement.data_side].add(register)

    def _occupy(self, unit: str, cycle: int, delay: int) -> None:
        self.units[cycle].add(unit)
        if delay >= 0:
            self.ports.add((unit, cycle + delay))

    def _cross(self, cycle: int, side: int, registers: Iterable[tuple[int, int] | int]) -> None:
        for register in registers:
            assert not isinstance(register, int)
            self.crossing[cycle, side] = register
            self.crossed[cycle, side] += 1

    def _count_reads(self, cycle: int, registers: Iterable[tuple[int, int] | int]) -> None:
        for register in registers:
            if not isinstance(register, int):
                self.reads[cycle, *register] += 1

    def _finished(self) -> Schedule:
        """The schedule with its return branch, which takes effect when every result has arrived."""
        last = max((each.cycle for each in self.result), default=0)
        landed = max((each.cycle + each.node.delay + 1 for each in self.result), default=0)
        counts = Counter[int]()
        for each in self.result:
            counts[each.cycle] += max(1, len(each.moves))
        for entry in self.frame:
            counts[entry.cycle] += 1
        if self.plan.saved:
            landed = max(landed, self._restore(counts))
        branch = max(0, last - BRANCH_SLOTS, landed - BRANCH_SLOTS - 1)
        while "S2" in self.units[branch] or counts[branch] >= _PACKET:
            branch += 1
        placements = sorted(self.result, key=lambda each: each.cycle)
        return Schedule(placements, branch, branch + BRANCH_SLOTS + 1, self.frame)

    def _all_saved(self) -> int:
        return max(frame.saved_at(pair, self.selected.stack) for pair in frame.PAIRS)

    def _restore(self, counts: Counter[int]) -> int:
        """Restore each pair behind the last instruction that reads or writes it; the cycle in which all is there."""
        quiet: dict[tuple[int, int], int] = {}
        for each in self.result:
            touched = [(each.cycle, operand) for operand in each.operands]
            touched += [(each.cycle, operand) for _, _, operand, _ in each.moves]
            if each.register is not None:
                touched.append((each.cycle + each.node.delay + 1, (each.data_side, each.register)))
            for cycle, register in touched:
                if not isinstance(register, int):
                    quiet[register] = max(quiet.get(register, 0), cycle)

        def free_from(pair: Pair) -> int:
            return max(self._all_saved() + 1, *(quiet.get((pair.side, each), 0) for each in pair.registers))

        def place(entry: FrameInstruction) -> FrameInstruction:
            while (
                entry.unit in self.units[entry.cycle]
                or (entry.cycle, entry.path) in self.paths
                or (entry.path is None and (entry.unit, entry.cycle) in self.ports)
                or counts[entry.cycle] >= _PACKET
            ):
                entry = replace(entry, cycle=entry.cycle + 1)
            self.units[entry.cycle].add(entry.unit)
            if entry.path is not None:
                self.paths.add((entry.cycle, entry.path))
            counts[entry.cycle] += 1
            self.frame.append(entry)
            return entry

        stack = self.selected.stack
        pairs = sorted(frame.PAIRS, key=free_from)
        loads = [place(load) for pair in pairs for load in frame.restored(pair, free_from(pair), stack)]
        end = max(entry.cycle for entry in loads)
        used = max((each.cycle for each in self.result if (1, 15) in each.operands), default=0)
        closing = place(frame.closed(max(end, used), stack))
        self.ports.add((closing.unit, closing.cycle))
        return max(end + LOAD_DELAY + 1, closing.cycle + 1)


_SWAPPED: Final = frozenset({"addsp", "mpysp", "add", "and", "or", "xor", "mpy32", "cmpeq", "cmpeqsp", *MIRRORED})


def _mirrored(node: Node) -> Node:
    """The comparison with exchanged operands."""
    return Node(MIRRORED[node.mnemonic], node.operands, node.units, node.delay, node.order)
