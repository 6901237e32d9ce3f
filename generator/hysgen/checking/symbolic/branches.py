"""Both sides of a branch, executed from the same state; behind it, a choice for every word in which they differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.memory import Leaf, Place, State, SymbolicMemory, Value, Whole
from hysgen.checking.symbolic.source import KernelRefusalError
from hysgen.codegen.operations.types import INTEGER

Result = TypeVar("Result")


@dataclass
class Branches:
    """Execution under conditions. memory: its state is that of the side that is being executed."""

    graph: Graph
    memory: SymbolicMemory

    def execute(self, before: State, side: Callable[[], Result]) -> tuple[State, Result]:
        """Execute code that runs under a condition, from a copy of the state; the state behind it and the result."""
        self.memory.state = before.copy()
        self.memory.conditional += 1
        result = side()
        self.memory.conditional -= 1
        return self.memory.state, result

    def merged(self, condition: Op, yes: State, no: State) -> State:
        """The state behind a branch: of every word in which the sides differ, the one that the condition chooses."""
        merged = State({}, yes.dirty | no.dirty)
        for key, value in {**yes.cells, **no.cells}.items():
            if yes.cells.get(key) is no.cells.get(key):
                merged.cells[key] = value
                continue
            leaves = []
            for side in (yes, no):
                self.memory.state = side
                leaves.append(self.memory.read(Place(key[0], key[1], INTEGER)))
            leaves[1] = self._stored_before(key, leaves[0], leaves[1])
            chosen = self.either(condition, leaves[0], leaves[1])
            assert isinstance(chosen, Op | Place)
            merged.cells[key] = chosen
        return merged

    def either(self, condition: Op, yes: Value, no: Value) -> Value:
        """The value that the condition chooses.

        Raises KernelRefusalError for two pointers that differ.
        """
        match yes, no:
            case Op(), Op():
                return self.graph.select(condition, yes, no)
            case Whole(), Whole():
                return Whole({k: self.either(condition, yes.leaves[k], no.leaves[k]) for k in yes.leaves})  # type: ignore[misc]
            case Place(), Place() if yes == no:
                return yes
            case None, None:
                return None
            case (Place(), _) | (_, Place()):
                return yes if isinstance(yes, Place) else no  # a pointer of one side only
        raise KernelRefusalError("the two sides of an if leave different pointers")

    def assumed(self, state: State, condition: Op) -> State:
        """The state where a condition holds: choices that it decides are made."""
        known = _facts(condition, True)
        cells = {
            key: self._decided(value, known) if isinstance(value, Op) else value for key, value in state.cells.items()
        }
        return State(cells, set(state.dirty))

    def _decided(self, value: Op, known: Mapping[int, bool]) -> Op:
        if value.kind != "select":
            return value
        condition, yes, no = value.args
        if id(condition) in known:
            return self._decided(yes if known[id(condition)] else no, known)
        conjuncts = _conjuncts(condition)
        left = [each for each in conjuncts if not known.get(id(each), False)]
        if any(known.get(id(each)) is False for each in left):
            return self._decided(no, known)
        if len(left) == len(conjuncts):
            return value
        yes = self._decided(yes, known)
        if not left:
            return yes
        condition = left[0]
        for each in left[1:]:
            condition = self.graph.op("and", condition, each)
        return self.graph.select(condition, yes, no)

    def _stored_before(self, key: tuple[str, int], new: Leaf, old: Leaf) -> Leaf:
        """The word as a load, if an earlier `if` may have changed it.

        The earlier value is stored at once. Both stores become stores under a condition, and the earlier value leaves
        its register.
        """
        if self.memory.conditional or not isinstance(new, Op) or new is old:
            return old
        return self.memory.settled(key, old)


def _facts(condition: Op, holds: bool) -> dict[int, bool]:
    """Which values, by their ids, are known to be other than 0 (True) or 0 (False) where a condition holds or fails."""
    found: dict[int, bool] = {}
    pending = [(condition, holds)]
    while pending:
        op, here = pending.pop()
        found[id(op)] = here
        zeros = [arg.kind == "const" and not arg.number for arg in op.args]
        match op.kind:
            case "and" if here and all(arg.truth for arg in op.args):
                pending += [(arg, True) for arg in op.args]
            case "or" if not here:
                pending += [(arg, False) for arg in op.args]
            case "xor" if op.truth and op.args[1].kind == "const" and op.args[1].number:
                pending.append((op.args[0], not here))
            case "cmpeq" if zeros[1]:
                pending.append((op.args[0], not here))
            case "select" if here and zeros[1]:
                pending += [(op.args[0], False), (op.args[2], True)]
            case "select" if here and zeros[2]:
                pending += [(op.args[0], True), (op.args[1], True)]
    return found


def _conjuncts(condition: Op) -> list[Op]:
    """The truths that all hold if the condition holds."""
    if condition.kind == "and" and all(arg.truth for arg in condition.args):
        return [each for arg in condition.args for each in _conjuncts(arg)]
    return [condition]
