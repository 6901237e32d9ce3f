"""Lines between and after the rows of numbers: a header that is repeated, where logs were put together, and footers.

A line is a row if its first used cell is a number or a time of day. A block of other lines

    that holds the header again    ends a part of the table; what follows is another part
    after the last row             is a footer, such as Max,54.2,4.1 or "End of measurement"
    anywhere else                  is a fault, which the reader of rows reports with its line
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hysgen.record.layout import Layout
from hysgen.record.lines import is_data, split
from hysgen.record.spelling import is_clock, quantity

MOST_FOOTER_LINES = 40
"""More lines than these after the last row are no footer: the table is damaged there."""


@dataclass(frozen=True)
class Parts:
    """The layout without interludes; line numbers are kept. starts: row at which each further part begins. remarks:
    one line for each kind of interlude."""

    layout: Layout
    starts: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()


def without_interludes(layout: Layout, use: Sequence[int]) -> Parts:
    """The parts of a table. use: positions of the columns that are read."""
    header, units = [*layout.names], [layout.units.get(name, "") for name in layout.names]
    lines = layout.body.split("\n")
    kept, starts, repeated = list(lines), [], []
    pending: list[int] = []
    rows = 0
    for at, line in enumerate(lines):
        if not is_data(line):
            continue
        fields = split(line, layout.separator)
        place = use[0] if use and use[0] < len(fields) else 0
        if is_clock(fields[place]) or quantity(fields[place], layout.comma) is not None:
            again = next((one for one in pending if split(lines[one], layout.separator) == header), None)
            if again is not None or (pending and split(lines[pending[-1]], layout.separator) == units):
                for one in pending:
                    kept[one] = ""
                starts.append(rows)
                repeated.append(layout.first + (pending[0] if again is None else again))
            pending = []
            rows += 1
        else:
            pending.append(at)
    remarks = []
    if repeated:
        shown = ", ".join(map(str, repeated[:3])) + (", ..." if len(repeated) > 3 else "")
        remarks.append(
            f"{layout.source}: the header is repeated in line {shown}; a part whose time begins anew is a segment"
        )
    if pending and rows and len(pending) <= MOST_FOOTER_LINES:
        for one in pending:
            kept[one] = ""
        shown = lines[pending[0]].strip()
        remarks.append(
            f"{layout.source}: line {layout.first + pending[0]} and what follows is no row of numbers and is left out "
            f"('{shown[:40]}{'...' if len(shown) > 40 else ''}')"
        )
    if not remarks:
        return Parts(layout)
    return Parts(replace(layout, body="\n".join(kept)), tuple(starts), tuple(remarks))
