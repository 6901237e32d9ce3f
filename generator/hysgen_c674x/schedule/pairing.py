"""64-bit stores: two stores of neighbouring words whose values are computed into neighbouring registers.

The address of the lower word is a multiple of 8. The register of the lower word is the even one of a pair.
"""

from collections.abc import Sequence
from typing import Final

from hysgen_c674x.schedule.instructions import Both, Node, Value, nodes_of

_NEAR: Final = 60
"""Instructions between two stores that may become one."""


def with_wide_stores(nodes: Sequence[Node]) -> list[Node]:
    """The instructions of a sequence, with a 64-bit store in the place of the later one of two stores."""
    users: dict[int, int] = {}
    ordered = {id(earlier) for node in nodes for earlier, _ in node.before if earlier.mnemonic == "stw"}
    for node in nodes:
        for value in node.values():
            users[id(value)] = users.get(id(value), 0) + 1
    open_stores: dict[tuple[int, int, int], tuple[int, Node]] = {}
    dropped: set[int] = set()
    zeros: dict[int, list[tuple[Node, Node]]] = {}
    for at, node in enumerate(nodes):
        if node.mnemonic != "stw" or node.word is None:
            continue
        key = id(node.operands[0]), id(node.guard), node.word // 2
        before = open_stores.pop(key, None)
        if before is None or at - before[0] > _NEAR or before[1].word == node.word or id(before[1]) in ordered:
            open_stores[key] = at, node
            continue
        earlier = before[1]
        low, high = sorted((earlier, node), key=lambda store: store.word or 0)
        values = _pair(low.operands[1], high.operands[1], at, users, zeros)
        if values is None:
            open_stores[key] = at, node
            continue
        dropped.add(id(earlier))
        node.before = [*earlier.before, *node.before]
        node.mnemonic, node.word, node.number = "stdw", low.word, low.number
        node.operands = [node.operands[0], *values]
    found: list[Node] = []
    for at, node in enumerate(nodes):
        found += [each for pair in zeros.get(at, ()) for each in pair]
        if id(node) not in dropped:
            found.append(node)
    used = {id(each) for node in found for value in node.values() for each in nodes_of(value)}
    return [node for node in found if id(node) in used or node.mnemonic != "mvk"]


def _pair(
    low: Value | int, high: Value | int, at: int, users: dict[int, int], zeros: dict[int, list[tuple[Node, Node]]]
) -> tuple[Node, Node] | None:
    """The values of both words, marked as a pair; None if they cannot be one."""
    if _zero(low) and _zero(high):
        if not zeros:
            for side in (0, 1):
                pair = [Node("mvk", [], "DLS", 0, 0, number=0, side=side, source=True) for _ in (0, 1)]
                zeros.setdefault(at, []).append((pair[0], pair[1]))
                _mark(*pair)
        (pairs,) = zeros.values()
        pairs.reverse()
        return pairs[0]
    if not isinstance(low, Node) or not isinstance(high, Node) or low is high:
        return None
    if low.second is high:
        return low, high
    for value in (low, high):
        if value.mnemonic in ("param", "select", "lddw", "second") or value.pair is not None or value.predicate:
            return None
    _mark(low, high)
    return low, high


def _mark(low: Node, high: Node) -> None:
    first, second = (each.operands[0] if each.in_place else each for each in (low, high))
    assert isinstance(first, Node)
    assert isinstance(second, Node)
    first.pair, second.pair = (second, 0), (first, 1)


def _zero(value: Value | int) -> bool:
    node = value.sides[0] if isinstance(value, Both) else value
    return isinstance(node, Node) and node.mnemonic == "mvk" and node.number == 0
