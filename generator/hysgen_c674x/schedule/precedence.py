"""What an instruction waits for, and what waits for it, while a schedule is being made."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from hysgen_c674x.schedule.instructions import Node, nodes_of
from hysgen_c674x.schedule.placement import Placement, Plan


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
