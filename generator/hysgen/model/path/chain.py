"""The float32 mirror of a model's input blocks in series: the generated `<name>_inputs_...` functions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hysgen.model.part import Words
from hysgen.model.path.base import Bits, BlockMirror, Floats32, InputBlock


class ChainMirror:
    """The blocks in series over lanes, at rest under the commands u_V (lanes,); without blocks, v = u.

    v_V: the last input of the stage.
    """

    def __init__(self, blocks: Sequence[InputBlock], u_V: Floats32, Ts_s: float) -> None:
        self._blocks: list[BlockMirror] = []
        self._limiters: list[BlockMirror] = []
        self._others: list[BlockMirror] = []
        v = u_V
        for block in blocks:
            mirror = block.mirror(v, Ts_s)
            self._blocks.append(mirror)
            (self._limiters if block.limits else self._others).append(mirror)
            v = mirror.rest()
        self.v_V = v

    def apply(self, u_V: Floats32) -> Floats32:
        """The input of the stage, (lanes,), for the commands u(k), (lanes,)."""
        for block in self._blocks:
            u_V = block.apply(u_V)
        self.v_V = u_V
        return u_V

    def reach(self, v_V: Floats32) -> Floats32:
        """v, (lanes,), after the limiters: the nearest input that can reach the stage."""
        for block in self._limiters:
            v_V = block.apply(v_V)
        self.v_V = v_V
        return v_V

    def command(self, v_V: Floats32) -> Floats32:
        """The command, (lanes,), for which v reaches the stage."""
        for block in self._others:
            v_V = block.command(v_V)
        return v_V

    def state(self) -> list[Words]:
        """Every 32-bit word of the C struct of the inputs, in its order; empty without blocks."""
        if not self._blocks:
            return []
        return [self.v_V, *(word for block in self._blocks for word in block.state())]

    def restore(self, words: Sequence[Bits]) -> None:
        """Set the state: the bits of every word in the order of `state`, (lanes,) each, for any number of lanes."""
        if not self._blocks:
            return
        self.v_V, first = words[0].view(np.float32), 1
        for block in self._blocks:
            count = len(block.state())
            block.restore(words[first : first + count])
            first += count
