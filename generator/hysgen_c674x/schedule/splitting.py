"""Instructions changed during an attempt, where registers are short: 64-bit accesses in two, an operand moved over."""

from dataclasses import replace

from hysgen_c674x.schedule.attempt import Attempt
from hysgen_c674x.schedule.instructions import PREDICATES, UNITS, WORD, Node, nodes_of


def split_store(attempt: Attempt, one: Node, other: Node) -> None:
    """Two stores in the place of a 64-bit store for whose values there are no neighbouring registers."""
    one.pair = other.pair = None
    stores = [user for each in (one, other) for user in attempt.order.users(each) if user.mnemonic == "stdw"]
    for store in {id(each): each for each in stores}.values():
        _split(attempt, store)


def _split(attempt: Attempt, store: Node) -> None:
    order, placed = attempt.order, attempt.placed
    base, low, high = store.operands
    assert isinstance(high, Node)
    assert not isinstance(base, int)
    store.mnemonic, store.operands = "stw", [base, low]
    second = replace(store, operands=[base, high], number=store.number + WORD, before=list(store.before))
    order.enter(second, store, 0.5, 0)
    order.followers[id(second)] = list(order.followers[id(store)])
    for follower, _ in order.followers[id(store)]:
        order.waiting[id(follower)] += 1
    order.followers[id(high)] = [
        (second if user is store else user, cycles) for user, cycles in order.followers[id(high)]
    ]
    order.consumers[id(high)] = [second if user is store else user for user in order.consumers[id(high)]]
    if id(high) not in placed:
        order.waiting[id(store)] -= 1
        order.waiting[id(second)] += 1
    else:
        order.ready_at[id(second)] = placed[id(high)].cycle + high.delay + 1
    for value in (*nodes_of(base), *([store.guard] if store.guard else [])):
        order.uses[id(value)] += 1
        order.consumers[id(value)].append(second)
        order.follow(second, value, value.delay + 1, placed)
    for earlier, cycles in store.before:
        order.follow(second, earlier, cycles, placed)
    for each in (store, second):
        if not order.waiting[id(each)] and (each is second or id(high) not in placed):
            order.await_cycle(each)


def split_load(attempt: Attempt, node: Node) -> None:
    """Two loads in the place of a 64-bit load for which there are no neighbouring registers."""
    order = attempt.order
    second, base = node.second, node.operands[0]
    assert second is not None
    assert not isinstance(base, int)
    node.mnemonic, node.second = "ldw", None
    second.mnemonic, second.units, second.operands, second.number = "ldw", "D", [base], node.number + WORD
    order.enter(second, node, 0.5, order.ready_at[id(node)])
    for value in nodes_of(base):
        order.uses[id(value)] += 1
        order.consumers[id(value)].append(second)
    order.await_cycle(second)
    if any(user.mnemonic == "stdw" for user in order.users(node)):
        split_store(attempt, node, second)


def moved_over(attempt: Attempt, node: Node, cycle: int) -> Node | None:
    """A move of an operand to the other side, where there is a register for the result of a stuck instruction.

    The instruction waits for the move from now on. None if there is no such register, and for a choice, a load or
    a store.
    """
    order, registers = attempt.order, attempt.registers
    operands = [each for each in node.operands if isinstance(each, Node)]
    kinds = PREDICATES if node.predicate else registers.general
    for side in (0, 1):
        far = [each for each in operands if attempt.placed[id(each)].data_side != side]
        free = [r for r in kinds[side] if r in registers.free[side]]
        fitting = len(free) >= (1 if node.predicate else 2)
        if id(node) in registers.reserved:
            fitting = bool(free) and registers.reserved[id(node)][0] == side
        if len(far) < 2 or not fitting or node.mnemonic == "select" or node.memory:
            continue
        move = Node("mv", [far[0]], *UNITS["mv"], node.order, side=side)
        node.operands[node.operands.index(far[0])] = move
        order.consumers[id(far[0])].remove(node)
        order.consumers[id(far[0])].append(move)
        order.consumers[id(move)].append(node)
        order.uses[id(move)] = 1
        attempt.made.append(move)
        order.enter(move, node, -0.25, cycle)
        order.height[id(move)] += 1
        order.followers[id(move)].append((node, 1))
        order.waiting[id(node)] += 1
        return move
    return None
