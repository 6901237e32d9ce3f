"""Straight-line code in the order of a software pipeline over blocks of independent elements.

A pipelined processor starts an operation in every cycle and has its result some cycles later; independent operations
must fill the cycles between. While block b loads, block b - 1 multiplies and block b - 2 adds. The operations of each
element and their order are those of a loop over the elements, so the result is the same in every bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

Block = TypeVar("Block")


@dataclass(frozen=True)
class Turn(Generic[Block]):
    """One stage of one block."""

    stage: str
    block: Block


def pipelined(blocks: Sequence[Block], stages: Sequence[str]) -> list[Turn[Block]]:
    """Every stage of every block, in the order of execution: stage s + 1 of block b - 1, then stage s of block b.

    An empty stage is a delay of one time slot. A stage of a block may read only values that earlier blocks wrote in the
    same stage or an earlier one.

    >>> [f"{turn.stage} {turn.block}" for turn in pipelined([1, 2, 3], ["load", "store"])]
    ['load 1', 'store 1', 'load 2', 'store 2', 'load 3', 'store 3']
    """
    turns: list[Turn[Block]] = []
    for time in range(len(blocks) + len(stages) - 1):
        for place in reversed(range(len(stages))):
            if stages[place] and 0 <= time - place < len(blocks):
                turns.append(Turn(stages[place], blocks[time - place]))
    return turns
