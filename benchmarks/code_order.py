"""Order of the functions in the C6748's memory that misses fewest lines of L1P, for firmware/board/c6748/c6748.ld.

Run:  python benchmarks/code_order.py      (about four minutes; needs firmware/toolchain/build_c674x.sh)
L1P is direct-mapped: two lines of code that are a multiple of 32 KiB apart replace each other. The script takes the
patterns of the linker script's .text, permutes them by simulated annealing and prints the order with the fewest missed
lines of an interrupt in TRACK with the learner, plus half of those of the idle loop, over four images (both reference
models, by gcc alone and with the kernels), each with the board functions of the simulator and of the C6748, and with
kernels of 90 % and 80 % of their length, so that the order survives a shorter kernel.
"""

from __future__ import annotations

import fnmatch
import math
import re
import sys
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np

from hysgen.firmware import firmware_model
from hysgen.model.model import Model
from hysgen_c674x.caches import L1P_LINE, L1P_SETS, program_lines
from hysgen_c674x.firmware.target import compile_image, link_image
from hysgen_c674x.firmware.timing import LEARN, LOOP, periods
from hysgen_c674x.processor import AccessKind, Trace
from hysgen_c674x.schedule.folder import kernels, with_kernels
from hysgen_c674x.toolchain import Firmware
from hysgen_lab.firmware.reference_models import firmware_models

SCRIPT = Path(__file__).resolve().parents[1] / "firmware" / "board" / "c6748" / "c6748.ld"
FIRST = 0x1180_4400 // L1P_LINE
PERIODS, STARTS, STEPS, SEED = 3, 4, 1500, 1
HOT, COLD = 40.0, 2.0
"""Temperatures of the annealing in missed lines, at its first and its last step."""
LENGTHS = (1.0, 0.9, 0.8)

Order = Sequence[Sequence[str]]
Fetches = list[tuple[str, int]]
"""Lines that a call fetches: function, number of the line in it."""


@dataclass(frozen=True)
class Case:
    """An image to place. sizes: lines by function. calls: fetches of interrupt and idle loop by turns."""

    sizes: Mapping[str, int]
    calls: Sequence[Fetches]

    def misses(self, order: Order) -> tuple[int, int]:
        """Most lines that an interrupt and an idle loop miss behind the first period."""
        place, at = {}, FIRST
        for name in placed(self.sizes, order):
            place[name], at = at, at + self.sizes[name]
        held: dict[int, int] = {}
        missed = []
        for call in self.calls:
            count = 0
            for name, offset in call:
                line = place[name] + offset
                count += held.get(line % L1P_SETS) != line
                held[line % L1P_SETS] = line
            missed.append(count)
        return max(missed[2::2]), max(missed[3::2])


def placed(sizes: Mapping[str, int], order: Order) -> Iterator[str]:
    """Functions as GNU ld places them: each where its first matching pattern stands; without a pattern, at the end."""
    left = dict.fromkeys(sorted(sizes))
    for patterns in [*order, ["*"]]:
        for name in [each for each in left if any(fnmatch.fnmatchcase(each, one) for one in patterns)]:
            del left[name]
            yield name


def patterns_of(script: str) -> list[list[str]]:
    """The patterns of .text, one list for each input statement, without the prefix of their section."""
    statements = re.findall(r"\*\((\.text\.[^)]*)\)", script)
    return [[each.removeprefix(".text.") for each in one.split()] for one in statements if one != ".text.*"]


def lines(size: int) -> int:
    """Lines of a function of `size` bytes that begins on a line."""
    return -(-size // L1P_LINE)


def fetches(model: Model, built: Firmware) -> tuple[dict[str, int], list[Fetches]]:
    """Lines by function; calls of the last PERIODS periods in TRACK, without the simulator's own functions."""
    functions = {s.name: s for s in built.image.symbols.values() if s.function and s.size}
    owner = {}
    for symbol in functions.values():
        if not symbol.name.startswith("hysgen_simulated_"):
            owner |= {symbol.address // L1P_LINE + i: (symbol.name, i) for i in range(lines(symbol.size))}
    kept = deque(periods(model, built.machine(), LOOP | LEARN, idle=True), maxlen=PERIODS)

    def of(trace: Trace) -> Fetches:
        words = trace.words[: trace.count]
        at = words[words >> np.uint64(32) & np.uint64(3) == AccessKind.FETCH] & np.uint64(0xFFFF_FFFF)
        touched = (line for address in at.tolist() for line in program_lines(built.packets[address]))
        return [owner[line] for line, _ in groupby(touched) if line in owner]

    sizes = {name: lines(symbol.size) for name, symbol in functions.items()}
    return sizes, [of(trace) for period in kept for trace in (period.interrupt, period.idle)]


def cases(name: str, scheduled: bool) -> Iterator[Case]:
    """The images of a reference model with the learner; scheduled: with the kernels."""
    (model,) = (each for each in firmware_models() if each.name == name)
    texts = firmware_model(model, aligned=scheduled)
    if scheduled:
        texts = with_kernels(name, texts, kernels(name, texts))
    sizes, calls = fetches(model, compile_image(texts))
    target = {f: lines(size) for f, size in link_image(name, texts).functions.items()}
    yield Case(sizes, calls)
    # On the C6748 the board's functions are longer; all of their lines are fetched.
    whole = [[one for each in call for one in (board(each, target) or [each])] for call in calls]
    for length in LENGTHS if scheduled else LENGTHS[:1]:
        shorter = {**target, f"{name}_learn": int(length * target[f"{name}_learn"])}
        yield Case(shorter, [[each for each in call if each[1] < shorter[each[0]]] for call in whole])


def board(fetch: tuple[str, int], target: Mapping[str, int]) -> Fetches:
    """All lines of the C6748's function in place of the first line of the simulator's; nothing for other functions."""
    name, offset = fetch
    return [(name, i) for i in range(target[name])] if name.startswith("hysgen_board_") and offset == 0 else []


def total(found: Sequence[Case], order: Order) -> float:
    """Missed lines of an interrupt, plus half of those of the idle loop, over all cases."""
    return sum(most + 0.5 * idle for case in found for most, idle in [case.misses(order)])


def annealed(found: Sequence[Case], order: Order, rng: np.random.Generator) -> tuple[float, Order]:
    """The best order of a walk of STEPS exchanges and moves of single statements, and its total."""
    now, here = list(order), total(found, order)
    best, lowest = now, here
    for step in range(STEPS):
        other = list(now)
        first, second = rng.choice(len(other), 2, replace=False)
        if rng.random() < 0.5:
            other.insert(second, other.pop(first))
        else:
            other[first], other[second] = other[second], other[first]
        there = total(found, other)
        temperature = HOT * (COLD / HOT) ** (step / STEPS)
        if there < here or rng.random() < math.exp((here - there) / temperature):
            now, here = other, there
        if here < lowest:
            best, lowest = now, here
    return lowest, best


def main() -> int:
    order = patterns_of(SCRIPT.read_text(encoding="utf-8"))
    found = [
        case for name in ("extended", "appendix_a") for scheduled in (True, False) for case in cases(name, scheduled)
    ]
    print(f"today: {total(found, order):.0f} lines", *(case.misses(order) for case in found))
    rng = np.random.default_rng(SEED)
    walks = [annealed(found, [order[i] for i in rng.permutation(len(order))], rng) for _ in range(STARTS)]
    lowest, best = min(walks, key=lambda each: each[0])
    print(f"best of {STARTS} walks: {lowest:.0f} lines", *(case.misses(best) for case in found))
    for patterns in best:
        print("        *(" + " ".join(f".text.{each}" for each in patterns) + ")")
    return 0


if __name__ == "__main__":
    sys.exit(main())
