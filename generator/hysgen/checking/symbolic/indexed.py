"""Memory whose words are all values: an element at an index that depends on data is an operation of the whole array.

`element` reads and `replaced` writes; neither says where the index lies. That it lies inside the array is shown
elsewhere (Frama-C), so two programs with equal operations compute equal words wherever both indices do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.memory import WORD, Leaf, Place, SymbolicMemory
from hysgen.checking.symbolic.source import KernelRefusalError
from hysgen.codegen.operations.text import INTEGER


def element(graph: Graph, words: Sequence[Op], distance: Op, offset: int = 0) -> Op:
    """The word at byte `offset` + distance of an array of words."""
    if distance.kind == "const":
        return words[(offset + distance.number) // WORD]
    return graph.indexed(words, distance, offset)


def replaced(
    graph: Graph, words: Sequence[Op], distance: Op, value: Op, offset: int = 0, stride: int = WORD
) -> list[Op]:
    """The words of an array after a store at byte `offset` + distance, a multiple of `stride`."""
    changed = list(words)
    for at in range(offset % stride, WORD * len(words), stride):
        here = graph.op("cmpeq", distance, graph.const(at - offset))
        changed[at // WORD] = graph.select(here, value, words[at // WORD])
    return changed


@dataclass
class IndexedMemory(SymbolicMemory):
    """All words that a function can read or write, none of them outside."""

    def read(self, place: Place) -> Leaf:
        if place.index is None:
            return super().read(place)
        return element(self.graph, self._array(place), place.index, place.offset - place.low)

    def write(self, place: Place, value: Leaf) -> None:
        if place.index is None:
            super().write(place, value)
            return
        if not isinstance(value, Op):
            raise KernelRefusalError(f"{place.memory}: a pointer stored at an index that depends on data")
        words = replaced(self.graph, self._array(place), place.index, value, place.offset - place.low, place.stride)
        for k, word in enumerate(words):
            super().write(Place(place.memory, place.low + WORD * k, INTEGER), word)

    def _array(self, place: Place) -> list[Op]:
        if place.high - place.low >= 1 << 29:
            raise KernelRefusalError(f"{place.memory}: an array of unknown size, indexed by data")
        places = (Place(place.memory, at, INTEGER) for at in range(place.low, place.high, WORD))
        leaves = [super(IndexedMemory, self).read(word) for word in places]
        if not all(isinstance(leaf, Op) for leaf in leaves):
            raise KernelRefusalError(f"{place.memory}: pointers indexed by data")
        return [leaf for leaf in leaves if isinstance(leaf, Op)]
