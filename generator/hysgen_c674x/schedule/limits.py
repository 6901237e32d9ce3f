"""What a kernel takes, beside what the C takes and what the C674x needs at least."""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from hysgen.checking.symbolic.from_c import kernel
from hysgen.checking.symbolic.source import Source
from hysgen.codegen.manifest import MANIFEST
from hysgen.display import table
from hysgen.errors import TargetError
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import bounds, c_texts
from hysgen_c674x.schedule.precedence import heights
from hysgen_c674x.schedule.selection import select


@dataclass(frozen=True)
class KernelCost:
    """Cycles of one function.

    scheduled: of the kernel; in_c: of the C by gcc, longest way, None if gcc has put it into its caller. Lower bounds:
    multipliers (two), adders (four units add floats), accesses (two data paths, 32 bits each), and the chain of
    latencies from an argument to a store or the return.
    """

    function: str
    scheduled: int
    in_c: int | None
    multipliers: int
    adders: int
    accesses: int
    chain: int


def kernel_costs(name: str, texts: Mapping[str, str]) -> list[KernelCost]:
    """The cost of every kernel of a folder; [] if it has none. Raises BuildError without the toolchain."""
    kernels = json.loads(texts[MANIFEST]).get("kernels", {}).get("cycles", {})
    if not kernels:
        return []
    units = [(file, text) for file, text in c_texts(texts) if "selftest" not in file]
    scheduled = toolchain.compile(units)
    portable = toolchain.compile(
        [(file, text) for file, text in units if not file.endswith(".s")], [f"-D{name.upper()}_PORTABLE"]
    )
    source = Source(name, texts)
    return [_cost(source, f"{name}_{function}", scheduled, portable) for function in kernels]


def _cost(source: Source, function: str, scheduled: toolchain.Firmware, portable: toolchain.Firmware) -> KernelCost:
    nodes = select(kernel(source, function)).nodes
    units = Counter(node.mnemonic for node in nodes)
    try:
        in_c = bounds(portable.image, portable.packets, function).worst
    except TargetError:
        in_c = None
    return KernelCost(
        function.removeprefix(f"{source.name}_"),
        bounds(scheduled.image, scheduled.packets, function).worst,
        in_c,
        -(-(units["mpysp"] + units["mpy32"]) // 2),
        -(-(units["addsp"] + units["subsp"]) // 4),
        -(-(units["ldw"] + units["stw"]) // 2),
        max(heights(nodes).values()),
    )


def kernel_table(costs: list[KernelCost]) -> str:
    """The costs as a table."""
    head = ["kernel", "cycles", "C by gcc", "at least: multipliers", "adders", "loads and stores", "latencies"]
    rows = [["-" if value is None else f"{value}" for value in asdict(cost).values()] for cost in costs]
    return "\n" + table(head, rows)
