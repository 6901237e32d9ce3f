"""Input blocks: models of amplifier and delay between the command and the stage.

Each kind is a class derived from `InputBlock` in a module here, and one template `path/<kind>.c.j2`. Modules are found
by listing this package, so these two add a kind.
"""

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hysgen.errors import ModelError
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, InputBlock

__all__ = [
    "BlockBox",
    "BlockMirror",
    "InputBlock",
    "applied",
    "block_from_json",
    "check_chain",
    "kinds",
    "path_range",
    "preview",
    "state_key",
]


@functools.lru_cache(maxsize=1)
def kinds() -> Mapping[str, type[InputBlock]]:
    """Every kind of input block that is installed, by name."""
    return InputBlock.kinds_in(__name__, __path__)


def block_from_json(data: Mapping[str, Any]) -> InputBlock:
    """Inverse of `InputBlock.to_json`. Raises ModelError if the kind is unknown or a field malformed."""
    kind = str(data.get("kind"))
    if kind not in kinds():
        raise ModelError(f"blocks: kind {kind!r} is unknown; this hysgen knows {', '.join(kinds())}")
    try:
        return kinds()[kind].from_json(data)
    except (KeyError, TypeError, ValueError) as fault:
        raise ModelError(f"blocks: {kind}: {fault}; write the model file with hysgen, do not edit it") from fault


def check_chain(blocks: Sequence[InputBlock]) -> None:
    """Check the blocks of a model: in the order of the signal, each kind at most once.

    Raises ModelError otherwise.
    """
    places = [block.place for block in blocks]
    if sorted(set(places)) != places:
        order = ", ".join(kind.kind for kind in sorted(kinds().values(), key=lambda kind: kind.place))
        raise ModelError(
            f"blocks: {', '.join(block.kind for block in blocks)}: each may stand once, in the order {order}"
        )


def path_range(blocks: Sequence[InputBlock], u_V: Interval) -> Interval:
    """Range of w, the input of the rules, for commands in u_V: V, or um behind a hysteresis.

    Without a response of the stage (hysteresis, creep, modes), the range of the command itself.
    """
    return _range_behind(tuple(blocks), u_V)


@functools.lru_cache(maxsize=64)
def _range_behind(blocks: tuple[InputBlock, ...], u_V: Interval) -> Interval:
    if not any(block.responds for block in blocks):
        return u_V
    for block in blocks:
        u_V = block.image(u_V)
    return u_V


def applied(
    blocks: Sequence[InputBlock],
    u_V: Floats,
    Ts_s: float,
    limits: Interval,
    start: Mapping[str, Floats] | None = None,
    aux: Mapping[str, Floats] | None = None,
) -> Floats:
    """w, (n,), of the commands u_V, (n,): the input after all blocks, from rest under u(0).

    limits: range of w (`path_range`), to which w is limited behind a response of the stage. start: states of blocks
    before the first sample, by `state_key`, where they are known. aux: the channels of blocks, (n,) each, by default
    at their middles.
    """
    for block in blocks:
        u_V = block.driven(u_V, aux, Ts_s, (start or {}).get(state_key(block)))
    return np.clip(u_V, limits.low, limits.high) if any(block.responds for block in blocks) else u_V


def state_key(block: InputBlock) -> str:
    """Key of a block's initial state in a mapping that holds the states of terms too."""
    return f"path.{block.kind}"


def preview(blocks: Sequence[InputBlock]) -> int:
    """Preview in samples: how far ahead the inverse needs its reference."""
    return sum(block.preview for block in blocks)
