"""Parquet and Feather files: columns of a table."""

from __future__ import annotations

from pathlib import Path

from hysgen.record.formats.base import FileArrays, Format, library, seconds

MAGIC = {b"PAR1": ("pyarrow.parquet", "Parquet files"), b"ARROW1": ("pyarrow.feather", "Feather files")}


def read_arrow(path: Path) -> FileArrays:
    """Columns of an Arrow table; time stamps as seconds since the first."""
    with path.open("rb") as stream:
        head = stream.read(6)
    name, what = next(reader for magic, reader in MAGIC.items() if head.startswith(magic))
    table = library(name, path, what).read_table(path)
    arrays, units = {}, {}
    for name in table.column_names:
        values = table.column(name).to_numpy()
        if values.dtype.kind in "mM":
            values, units[str(name)] = seconds(values), "s"
        if values.dtype.kind in "fiub":
            arrays[str(name)] = values
    return FileArrays(arrays, units)


FORMAT = Format("arrow", lambda path, head: head.startswith(tuple(MAGIC)), read_arrow)
