"""Tables of text, for terminals and notebooks."""

from __future__ import annotations

from collections.abc import Sequence


def table(header: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """Columns aligned by their widest cell: the first `left` of them to the left, the others, numbers, to the right.

    >>> print(table(["model", "rms"], [["base", "0.47"], ["extended", "0.1"]]))
    model      rms
    --------  ----
    base      0.47
    extended   0.1
    """
    cells = [list(header), *[list(row) for row in rows]]
    widths = [max(len(row[j]) for row in cells) for j in range(len(header))]

    def line(row: Sequence[str]) -> str:
        columns = enumerate(zip(row, widths, strict=True))
        return "  ".join(cell.ljust(w) if j < left else cell.rjust(w) for j, (cell, w) in columns).rstrip()

    return "\n".join([line(cells[0]), "  ".join("-" * width for width in widths), *[line(row) for row in cells[1:]]])
