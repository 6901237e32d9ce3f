"""Which operations of a graph are equal for every input: by their form, or by a solver where the form differs.

The graph is swept from its inputs to its outputs. An operation whose operands were replaced by their representatives
is the operation of that form that exists already, or a new one. A new one that had the bits of an earlier one in every
drawn sample is handed to the solver (Bitwuzla) together with it; if no input can tell them apart, the earlier one takes
its place, and what stands on both becomes equal by form.

Source of the method: Kuehlmann, Krohm, Equivalence checking using cuts and heaps (1997).
"""

import functools
import itertools
import operator
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.symbolic.arrays import COMPUTED, Words
from hysgen.checking.symbolic.dataflow import Graph, Op, bottom_up
from hysgen.checking.symbolic.from_c import Decision
from hysgen.checking.symbolic.solver import Solver, rebuilt, variables
from hysgen.checking.symbolic.source import KernelRefusalError

SAMPLES: Final = 512
"""Drawn inputs: operations that differ in one of them are not handed to the solver."""
CANDIDATES: Final = 16
"""Earlier operations with the same bits that the solver is asked about."""
MOST_ASKED: Final = 3000
"""Pairs that the solver is handed in one sweep; what is left then stays open."""
MOST_SPLIT: Final = 7
"""Operations of a disjunction whose parts, up to four, are cases. A longer one holds or fails as a whole."""
_SOLVED: Final[Mapping[str, str]] = {
    "select": "selections",
    **dict.fromkeys(("cmpeq", "cmpgtu", "cmpltu", "cmpeqsp", "cmpgtsp", "cmpltsp"), "comparisons"),
    **dict.fromkeys(("and", "or", "xor"), "bits"),
}
"""Operations that the solver is asked about: what is decided of them."""


@dataclass(frozen=True)
class Case:
    """A case of two programs: truths by the id of their representative. known, true: sets of bits, one for each truth.
    of: what an operation becomes, and the set of the truths on which that depends.."""

    decided: Mapping[int, int]
    known: int = 0
    true: int = 0
    of: dict[int, tuple[Op, int]] = field(default_factory=dict)


def _atom(condition: Op) -> Op:
    """A truth that a condition depends on: no constant, conjunction, negation or short disjunction."""
    while condition.kind in ("and", "xor", "select", "cmpeq", "or") and condition.args[0].truth:
        if condition.kind == "or" and len(_decided(condition, 0)) > MOST_SPLIT:
            return condition
        condition = condition.args[0]
    return condition


def _decided(atom: Op, truth: int) -> dict[int, int]:
    """The truths that follow from one: where a disjunction fails, every part of it fails."""
    pending, known = [atom], {}
    while pending:
        op = pending.pop()
        known[id(op)] = truth
        pending += op.args if op.kind == "or" and not truth else ()
    return known


@dataclass
class Sweep:
    """Representatives of operations.

    drawn: SAMPLES values of an input, a `symbol` or a `param`. by_cases: whether the programs branch often. asked,
    decided: pairs that the solver was handed, and those that it found equal, by kind; solver_s: its time. side: 0 or 1,
    which of two programs the next operations belong to; within a program only selections are compared, such as limits
    that never act.
    """

    drawn: Callable[[Op], Words]
    facts: Sequence[Op] = ()
    graph: Graph = field(default_factory=Graph)
    by_cases: bool = False
    side: int = 0
    asked: int = 0
    decided: Counter[str] = field(default_factory=Counter)
    solver_s: float = 0.0
    _of: dict[int, Op] = field(default_factory=dict)
    _merged: dict[int, Op] = field(default_factory=dict)
    _values: dict[int, Words] = field(default_factory=dict)
    _alike: dict[bytes, list[Op]] = field(default_factory=dict)
    _side: dict[int, int] = field(default_factory=dict)
    _held: list[Op] = field(default_factory=list)
    _bit: dict[int, int] = field(default_factory=dict)
    _below: dict[int, int] = field(default_factory=dict)
    _restrictions: dict[int, dict[int, dict[tuple[int, int], Op]]] = field(default_factory=dict)
    _solver: Solver | None = None

    def __post_init__(self) -> None:
        self._solver = Solver.installed()
        if self._solver is not None and self.facts:
            self._solver.know([self.representative(fact) for fact in self.facts])

    def representative(self, op: Op, case: Case | None = None) -> Op:
        """The operation that stands for every operation that is equal to `op`, in a case of the truths in it."""
        whole = bottom_up(op, self._of, self._standing)
        return whole if case is None or not case.decided else self._restricted(whole, case)

    def _standing(self, op: Op) -> Op:
        self._held.append(op)
        return self._placed(rebuilt(self.graph, op, [self._of[id(arg)] for arg in op.args]))

    def _restricted(self, op: Op, case: Case) -> Op:
        """A representative with the truths of a case in place of its conditions.

        What it becomes depends on the truths that were met on the way alone, so most of a case is known from others.
        """
        pending, known, begun = [op], case.of, set[int]()
        while pending:
            top = pending[-1]
            begun.add(id(top))
            if id(top) in known:
                pending.pop()
            elif earlier := self._from_earlier_case(top, case):
                known[id(top)] = earlier
            elif id(top) in case.decided:
                known[id(top)] = self._placed(self.graph.const(case.decided[id(top)])), self._below[id(top)]
            elif missing := [arg for arg in top.args if id(arg) not in known]:
                pending += missing
            else:
                args = [known[id(arg)][0] for arg in top.args]
                same = all(new is old for new, old in zip(args, top.args, strict=True))
                new = top if same else self._placed(rebuilt(self.graph, top, args))
                if same or id(new) in known or id(new) in begun:
                    result, met = known.get(id(new), (new, self._below[id(new)]))
                    for arg in top.args:
                        met |= known[id(arg)][1]
                    met |= self._below[id(top)]
                    known[id(top)] = result, met
                    table = self._restrictions.setdefault(id(top), {}).setdefault(met, {})
                    table[case.known & met, case.true & met] = result
                else:
                    pending.append(new)
        return known[id(op)][0]

    def _from_earlier_case(self, op: Op, case: Case) -> tuple[Op, int] | None:
        """What an operation became in a case with the same truths, and the truths on which that depends."""
        if not self._below[id(op)] & case.known:
            return op, self._below[id(op)]
        tables = self._restrictions.get(id(op), {})
        for met in reversed(tables):
            if result := tables[met].get((case.known & met, case.true & met)):
                tables[met] = tables.pop(met)  # the next case is like this one
                return result, met
        return None

    def pairs(self, programs: Sequence[tuple[Op, Op]], case: Case | None = None) -> list[tuple[Op, Op]]:
        """Representatives of the results of two programs, pair by pair."""
        made = []
        for side in (0, 1):
            self.side = side
            made.append([self.representative(pair[side], case) for pair in programs])
        return list(zip(*made, strict=True))

    def cases(self, decisions: Sequence[Decision], decided: Mapping[int, int] | None = None) -> Iterator[Case]:
        """All cases of the truths on which the decisions of the first program depend."""
        self.side = 0
        bits = {key: self._bit[key] for key in decided or {}}
        case = Case(
            decided or {}, sum(bits.values()), sum(bits[key] for key, truth in (decided or {}).items() if truth)
        )
        for place, decision in enumerate(decisions):
            around = [(self.representative(op, case), side) for op, side in decision.around]
            if any(op.kind == "const" and bool(op.number) != side for op, side in around):
                continue
            condition = self.representative(decision.condition, case)
            if condition.kind != "const":
                atom = _atom(condition)
                if not atom.truth:
                    raise KernelRefusalError(f"a branch on a word, {atom.kind}, that is not 0 or 1")
                for truth in (0, 1):
                    yield from self.cases(decisions[place:], {**case.decided, **_decided(atom, truth)})
                return
        yield case

    def holds(self, case: Case) -> NDArray[np.bool_]:
        """The drawn samples that belong to a case."""
        met = np.ones(SAMPLES, np.bool_)
        for key, truth in case.decided.items():
            met &= self._values[key] == truth
        return met

    def values(self, op: Op) -> Words:
        """The drawn samples of a representative."""
        return self._values[id(op)]

    def _placed(self, op: Op) -> Op:
        """The representative of an operation of the sweep's own graph, whose operands may be new, too."""
        return bottom_up(op, self._merged, self._earlier)

    def _earlier(self, op: Op) -> Op:
        """An operation with the same value for every input that was placed before, or the operation itself."""
        args = [self._merged[id(arg)] for arg in op.args]
        if any(new is not old for new, old in zip(args, op.args, strict=True)):
            return self._placed(rebuilt(self.graph, op, args))
        below = [self._below[id(arg)] for arg in args]
        if op.kind != "const" and op.truth:
            below.append(self._bit.setdefault(id(op), 1 << len(self._bit)))
        self._below[id(op)] = functools.reduce(operator.or_, below, 0)
        bits = self._values[id(op)] = self._computed(op)
        alike = self._alike.setdefault(bits.tobytes(), [])
        if self._solver is not None and op.kind in _SOLVED and self.asked < MOST_ASKED and self._worth_asking(op):
            own = set(map(id, variables(op)))
            candidates = [
                other for other in alike if self._side[id(other)] != self.side or op.kind == other.kind == "select"
            ]
            candidates.sort(key=lambda other: other.kind != op.kind)
            related = (other for other in candidates if _nested(own, set(map(id, variables(other)))))
            for other in itertools.islice(related, CANDIDATES):
                self.asked += 1
                begun = time.monotonic()
                equal = self._solver.equal(op, other)
                self.solver_s += time.monotonic() - begun
                if equal:
                    self.decided[_SOLVED[op.kind]] += 1
                    return other
        alike.append(op)
        self._side[id(op)] = self.side
        return op

    def _worth_asking(self, op: Op) -> bool:
        """With cases: whether the samples exercise it. A condition that they never meet is decided by a case."""
        if not self.by_cases:
            return True
        moving = self._values[id(op.args[0] if op.kind == "select" else op)]
        return op.kind != "or" and bool(moving.min() < moving.max())  # a disjunction: many alike, and one form each

    def _computed(self, op: Op) -> Words:
        inputs = [self._values[id(arg)] for arg in op.args]
        match op.kind:
            case "const":
                return np.full(SAMPLES, op.number, np.uint32)
            case "param" | "symbol":
                return self.drawn(op)
            case "element":
                table = np.stack(inputs[1:])
                place = (inputs[0].astype(np.int64) + op.number) // 4 % len(table)
                return table[place, np.arange(SAMPLES)]
        return np.asarray(COMPUTED[op.kind](*inputs), np.uint32)


def _nested(some: set[int], others: set[int]) -> bool:
    return some <= others or others <= some
