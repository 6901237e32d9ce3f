"""MAT files of version 4, 5 and 7.3: numeric variables, fields of structures, tables and timetables."""

import contextlib
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from scipy.io.matlab import MatlabOpaque

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array, FileArrays, Format, check_size, one_line
from hysgen.record.formats.hdf5 import MAGIC, MATLAB_BLOCK, read_hdf5, read_tables


def read_mat(path: Path) -> FileArrays:
    """All numeric variables of a MAT file; fields of structures as "structure/field". v7.3 is read as HDF5."""
    start = path.read_bytes()[: MATLAB_BLOCK + len(MAGIC)]
    if start.startswith(MAGIC) or start.endswith(MAGIC):
        return read_hdf5(path)
    if not start.startswith(b"MATLAB 5.0 MAT-file") and not _is_mat_4(path):
        raise RecordError(f"{path.name}: is not a MAT file of version 4, 5 or 7.3; save it with MATLAB's -v7 or -v7.3")
    try:
        with contextlib.suppress(TypeError):  # objects have no shape
            check_size(path, sum(8 * math.prod(shape) for _, shape, _ in scipy.io.whosmat(str(path))))
        content = scipy.io.loadmat(str(path), simplify_cells=True)
    except RecordError:
        raise
    except Exception as fault:  # SciPy's parser may raise any exception on a damaged file
        raise RecordError(f"{path.name}: is damaged ({one_line(fault)}); save it again") from fault
    arrays = dict(_flat("", content))
    if not arrays and any(isinstance(item, MatlabOpaque) for item in content.values()):
        return read_tables(path)
    return FileArrays(arrays)


def _is_mat_4(path: Path) -> bool:
    """Whether the first word of a file is the type of a matrix of version 4, which has no signature."""
    try:
        return bool(scipy.io.matlab.matfile_version(str(path))[0] == 0)
    except (ValueError, OSError, scipy.io.matlab.MatReadError):
        return False


def _flat(prefix: str, content: Mapping[str, Any]) -> Iterator[tuple[str, Array]]:
    """Numeric variables of nested dictionaries, by path.

    An item of a structure array has the name that it gives itself (Simulink: label, dSPACE: Name), else its number from
    1; a structure with `Data` or `values` (dSPACE, Simulink) is that array.
    """
    for name, item in content.items():
        if isinstance(item, Mapping):
            held = next((item[key] for key in ("Data", "data", "values") if key in item), None)
            if held is not None and not isinstance(held, (Mapping, str)) and np.asarray(held).dtype.kind in "fiub":
                yield prefix + (_given_name(item) or ("time" if name == "X" else name)), np.asarray(held)
            else:
                yield from _flat(f"{prefix}{name}/", item)
        elif (
            isinstance(item, (list, np.ndarray)) and len(np.atleast_1d(item)) and isinstance(np.ravel(item)[0], Mapping)
        ):
            parts = [(_given_name(one) or f"{name}{number}", one) for number, one in enumerate(np.ravel(item), 1)]
            yield from _flat(f"{prefix}{name}/", dict(parts))
        elif not name.startswith("__") and np.asarray(item).dtype.kind in "fiub":
            yield prefix + name, np.asarray(item)


def _given_name(item: Mapping[str, Any]) -> str:
    """The name in the fields of a structure; "" if it has none."""
    given = next((item[key] for key in ("label", "Name", "name") if isinstance(item.get(key), str)), "")
    return str(given).strip().replace("/", " ")


FORMAT = Format("mat", lambda path, head: head.startswith(b"MATLAB") or path.suffix.lower() == ".mat", read_mat)
