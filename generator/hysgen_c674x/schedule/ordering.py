"""A sequence of the computing instructions of a kernel in which few values are alive at a time.

The instructions keep the order of the C text, but an instruction that frees at least as many registers as it takes
comes as soon as its operands are there (Goodman and Hsu, ICS 1988).
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict

from hysgen_c674x.schedule.instructions import Node, Selected, nodes_of


def sparing(selected: Selected, constants_last: bool = False) -> dict[int, int]:
    """The rank of every computing instruction, by its id; loads from known addresses and constants have none.

    The result comes last, because its register holds an argument. constants_last: whether stores that free no register
    come last, too.
    """
    nodes = [node for node in selected.nodes if not node.source]
    late = {id(node) for node in nodes if constants_last and _stores_constant(node)} | {id(selected.result)}
    nodes.sort(key=lambda node: id(node) in late)
    rank = {id(node): k for k, node in enumerate(nodes)}
    uses: Counter[int] = Counter()
    waiting: Counter[int] = Counter()
    followers: dict[int, list[Node]] = defaultdict(list)
    readers: dict[int, list[Node]] = defaultdict(list)
    for node in nodes:
        for value in _computed(node):
            uses[id(value)] += 1
            readers[id(value)].append(node)
        for earlier in _earlier(node, rank):
            followers[id(earlier)].append(node)
            waiting[id(node)] += 1
    ready = [(rank[id(node)], node) for node in nodes if not waiting[id(node)]]
    heapq.heapify(ready)
    freeing: list[tuple[int, Node]] = []
    found: dict[int, int] = {}

    def taken(node: Node) -> int:
        dying = sum(uses[id(value)] == 1 for value in _computed(node))
        return (1 if node.writes else 0) - dying

    def ready_one() -> Node:
        while freeing:
            node = heapq.heappop(freeing)[1]
            if id(node) not in found:
                return node
        while True:
            node = heapq.heappop(ready)[1]
            if id(node) not in found:
                return node

    def frees(node: Node) -> bool:
        return id(node) not in late and taken(node) <= 0

    for key, node in ready:
        if frees(node):
            heapq.heappush(freeing, (key, node))
    while len(found) < len(nodes):
        node = ready_one()
        found[id(node)] = len(found)
        for value in _computed(node):
            uses[id(value)] -= 1
            if uses[id(value)] == 1:
                for reader in readers[id(value)]:
                    if id(reader) not in found and not waiting[id(reader)] and frees(reader):
                        heapq.heappush(freeing, (rank[id(reader)], reader))
        for follower in followers[id(node)]:
            waiting[id(follower)] -= 1
            if not waiting[id(follower)]:
                heapq.heappush(freeing if frees(follower) else ready, (rank[id(follower)], follower))
    return found


def _stores_constant(node: Node) -> bool:
    """Whether an instruction stores a constant or a word of memory, which can be made again at any time."""
    if node.mnemonic != "stw" or isinstance(node.operands[1], int):
        return False
    return all(each.source for each in nodes_of(node.operands[1]))


def ranked(selected: Selected, constants_last: bool = False) -> Selected:
    """The instructions with the order of `sparing`; a load or constant stands in front of its first user."""
    rank = sparing(selected, constants_last)
    users: dict[int, list[Node]] = defaultdict(list)
    for node in selected.nodes:
        for value in node.values():
            for each in nodes_of(value):
                users[id(each)].append(node)
    place: dict[int, float] = {key: float(at) for key, at in rank.items()}
    for node in reversed(selected.nodes):
        if node.source:
            place[id(node)] = min((place[id(user)] for user in users[id(node)]), default=0.0) - 0.01
    by_place = sorted(selected.nodes, key=lambda node: place[id(node)])
    for order, node in enumerate(by_place):
        node.order = order
    return selected


def _computed(node: Node) -> list[Node]:
    """The operands that are not constants, words of memory or addresses."""
    found = {id(each): each for value in node.values() for each in nodes_of(value) if not each.source}
    return [each for each in found.values() if each.mnemonic != "param"]


def _earlier(node: Node, rank: dict[int, int]) -> list[Node]:
    """What must stand in front of an instruction: its operands, and stores to the words that it reads or overwrites."""
    found: dict[int, Node] = {}
    pending = [*(each for value in node.values() for each in nodes_of(value)), *(each for each, _ in node.before)]
    seen: set[int] = set()
    while pending:
        each = pending.pop()
        if id(each) in seen:
            continue
        seen.add(id(each))
        if id(each) in rank:
            found[id(each)] = each
        elif each.source:
            pending += [*(one for value in each.values() for one in nodes_of(value)), *(one for one, _ in each.before)]
    return list(found.values())
