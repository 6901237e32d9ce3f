"""Straight code in the order of a software pipeline: blocks of independent elements, each some stages behind the next.

A processor that starts an operation in every cycle and has its result some cycles later is busy only if something
independent stands in between. So while one block loads, the block before multiplies and the one before that adds. The
operations of every element, and their order, are those of the loop: no bit depends on it.
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
    """Every stage of every block: stage s of a block stands beside stage s + 1 of the block before it, behind it.

    An empty stage is a pause. What a stage of one block reads, the blocks before must have written in an earlier stage,
    or in the same one.

    >>> [f"{turn.stage} {turn.block}" for turn in pipelined([1, 2, 3], ["load", "store"])]
    ['load 1', 'store 1', 'load 2', 'store 2', 'load 3', 'store 3']
    """
    turns: list[Turn[Block]] = []
    for time in range(len(blocks) + len(stages) - 1):
        for place in reversed(range(len(stages))):
            if stages[place] and 0 <= time - place < len(blocks):
                turns.append(Turn(stages[place], blocks[time - place]))
    return turns
