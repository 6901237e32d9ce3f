"""What an instruction waits for, and what waits for it, while a schedule is being made.

A sequence of the computing instructions of a kernel in which few values are alive at a time.

The instructions keep the order of the C text, but an instruction that frees at least as many registers as it takes
comes as soon as its operands are there (Goodman and Hsu, ICS 1988).
"""

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from hysgen_c674x.schedule.instructions import Node, Placement, Plan, Selected, nodes_of


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
class Precedence:
    """Instructions, by id, and what precedes them.

    position: in the order of the C text. height: of `heights`. due: cycle before which nothing hurries. consumers:
    instructions that read a value; uses: how many of them are still to come. followers: (instruction, cycles) that
    wait; waiting: for how many; ready_at: cycle before which an instruction is not issued. pending: (ready_at,
    position, instruction) of those that wait for a cycle only. left: instructions without a place.
    """

    position: dict[int, float]
    height: dict[int, int]
    due: dict[int, float]
    consumers: dict[int, list[Node]] = field(default_factory=lambda: defaultdict(list))
    uses: Counter[int] = field(default_factory=Counter)
    followers: dict[int, list[tuple[Node, int]]] = field(default_factory=lambda: defaultdict(list))
    waiting: Counter[int] = field(default_factory=Counter)
    ready_at: dict[int, int] = field(default_factory=dict)
    pending: list[tuple[int, float, Node]] = field(default_factory=list)
    left: int = 0

    def users(self, node: Node) -> list[Node]:
        """The users of a value; of the lower half of a constant, those of the constant."""
        return [user for each in self.consumers[id(node)] for user in (self.users(each) if each.in_place else [each])]

    def await_cycle(self, node: Node) -> None:
        """Nothing but a cycle is missing for an instruction."""
        heapq.heappush(self.pending, (self.ready_at[id(node)], self.position[id(node)], node))

    def arrived(self, cycle: int) -> Iterable[Node]:
        """Take the instructions that are ready in a cycle."""
        while self.pending and self.pending[0][0] <= cycle:
            yield heapq.heappop(self.pending)[2]

    def issued(self, node: Node, cycle: int) -> None:
        """Count an instruction as issued in a cycle, for all that wait for it."""
        self.left -= 1
        released = list(self.followers[id(node)])
        if node.second is not None:
            released += self.followers[id(node.second)]
        for follower, cycles in released:
            self.waiting[id(follower)] -= 1
            self.ready_at[id(follower)] = max(self.ready_at[id(follower)], cycle + cycles)
            if not self.waiting[id(follower)]:
                self.await_cycle(follower)

    def enter(self, new: Node, like: Node, distance: float, ready_at: int) -> None:
        """Take up an instruction that this attempt has made, at a distance in the order from one that it is like."""
        self.position[id(new)] = self.position[id(like)] + distance
        self.height[id(new)], self.due[id(new)] = self.height[id(like)], self.due[id(like)]
        self.ready_at[id(new)] = ready_at
        self.left += 1

    def follow(self, node: Node, earlier: Node, cycles: int, placed: Mapping[int, Placement]) -> None:
        """Let an instruction wait for an earlier one, which may have its place already."""
        if id(earlier) in placed:
            self.ready_at[id(node)] = max(self.ready_at[id(node)], placed[id(earlier)].cycle + cycles)
        else:
            self.followers[id(earlier)].append((node, cycles))
            self.waiting[id(node)] += 1


def precedence(nodes: Sequence[Node], plan: Plan, issue: Mapping[int, int] | None) -> Precedence:
    """What precedes each instruction before the first one has its place.

    issue: cycles of an attempt without limits on registers, for the release of loads and constants; None if they are in
    their places.
    """
    by_order = sorted(nodes, key=lambda node: node.order)
    height = heights(nodes)
    end = plan.stretch * max(height.values(), default=0)
    due = {id(node): end - height[id(node)] - plan.lead for node in nodes}
    found = Precedence({id(node): k for k, node in enumerate(by_order)}, height, due, left=len(nodes))
    for node in nodes:
        for value in node.values():
            for each in nodes_of(value):
                found.uses[id(each)] += 1
                found.consumers[id(each)].append(node)
                found.followers[id(each)].append((node, each.delay + 1))
                found.waiting[id(node)] += 1
        for earlier, cycles in node.before:
            found.followers[id(earlier)].append((node, cycles))
            found.waiting[id(node)] += 1
    for node in nodes:
        anytime = issue is None or not node.source or plan.stretch
        found.ready_at[id(node)] = 0 if anytime else _released(found, node, plan, issue)  # type: ignore[arg-type]
    return found


def _released(found: Precedence, node: Node, plan: Plan, issue: Mapping[int, int]) -> int:
    """Earliest cycle of a load or constant: a few cycles before its first use in an attempt without limits."""
    return max(0, _needed(found, node, issue) - node.delay - 1 - plan.lead)


def _needed(found: Precedence, node: Node, issue: Mapping[int, int]) -> int:
    """The cycle in which the first instruction that uses a value, or a source made from it, was issued."""
    first = 1 << 30
    for user in found.consumers[id(node)]:
        first = min(first, _needed(found, user, issue) - user.delay - 1 if user.source else issue[id(user)])
    return first if first < 1 << 30 else 0


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
