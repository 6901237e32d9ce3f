"""WAV: channels as "channel 1" onwards, every 1/rate; whole numbers become shares of full scale, -1 to 1."""

from pathlib import Path

import numpy as np
import scipy  # its parts are imported where they work

from hysgen.record.formats.base import FileArrays, Format


def read_wav(path: Path) -> FileArrays:
    """All channels of a WAV file."""
    rate_Hz, values = scipy.io.wavfile.read(path)
    remarks: tuple[str, ...] = ()
    if values.dtype.kind in "iu":
        limits = np.iinfo(values.dtype)
        half = 0.5 * (float(limits.max) - float(limits.min) + 1.0)
        values = (values.astype(np.float64) - (half + float(limits.min))) / half
        remarks = (f"{path.name}: whole numbers are taken as shares of full scale, -1 to 1; save floats to keep units",)
    columns = values.reshape(len(values), -1).T
    return FileArrays({f"channel {i}": column for i, column in enumerate(columns, 1)}, {}, 1.0 / rate_Hz, remarks)


FORMAT = Format("wav", lambda path, head: head[:4] in (b"RIFF", b"RF64") and head[8:12] == b"WAVE", read_wav)
