"""Files of instruments, loggers, spreadsheets and programs are read and said; bad ones, bad options and files of other
kinds are refused in one line with file, field and cure; no code runs.

samples.toml holds one text file a kind. `said`: part of a remark of the reading, nothing for none. `refused`: parts of
the message in order; what it says to paste reads the file, with `pasted` behind it, where the sample has this field.
"""

import gzip
import math
import os
import pickle
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from fixtures.record_of_files import SAMPLES, check, sample_text
from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record
from hysgen.record.arrays import FileArrays, find
from hysgen.record.sampling import sampling_period
from hysgen.record.segment import Origin, Segment

USUAL = Columns()
HEADER = "time_s,voltage_V,displacement_um"
K = np.arange(400)
TIME_S = np.round(K * 1e-3, 3)
# A sound record: 4 cycles at 100 samples each, the displacement a little late and with 1 nm of sensor noise.
U_V = np.round(50 + 40 * np.sin(2 * np.pi * K / 100), 6)
Y_UM = np.round(5 + 3 * np.sin(2 * np.pi * (K - 4) / 100) + 1e-3 * np.random.default_rng(7).normal(size=400), 4)
ROWS = [f"{t},{u},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True)]
CLIPPED_UM = np.minimum(Y_UM, 7.5)
SPREAD_UM = np.stack([Y_UM, Y_UM], axis=1)
SEGMENT = Segment("0", U_V, Y_UM)


class Frame(dict[str, np.ndarray]):
    """What a DataFrame is to hysgen."""

    columns = property(list)


FRAME = Frame(voltage_V=U_V, displacement_um=Y_UM)


def picked(index: str) -> object:
    """What an index picks from an array of two columns."""
    return list(find("f", FileArrays({"u": SPREAD_UM}), USUAL, "voltage", f"u[{index}]"))


def text() -> bytes:
    """The sound record as CSV."""
    return "\n".join([HEADER, *ROWS, ""]).encode()


def table(u_V: np.ndarray, y_um: np.ndarray, time_s: np.ndarray = TIME_S) -> bytes:
    return "\n".join([HEADER, *(f"{t},{u},{y}" for t, u, y in zip(time_s, u_V, y_um, strict=True)), ""]).encode()


def npz(**arrays: object) -> bytes:
    stream = BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def mat(**arrays: np.ndarray) -> bytes:
    stream = BytesIO()
    scipy.io.savemat(stream, arrays)
    return stream.getvalue()


def hdf5(**arrays: np.ndarray) -> bytes:
    stream = BytesIO()
    with h5py.File(stream, "w") as file:
        for name, values in arrays.items():
            file[name] = values
    return stream.getvalue()


def sound(**changes: object) -> dict[str, object]:
    arrays = {"time_s": TIME_S, "voltage_V": U_V, "displacement_um": Y_UM} | changes
    return {name: values for name, values in arrays.items() if values is not None}


@dataclass(frozen=True)
class Bad:
    """One kind of bad input: what the file holds, how it is read, and what the message says, in this order."""

    kind: str
    file: str
    content: bytes
    says: tuple[str, ...]
    columns: Columns = USUAL


BAD = [
    Bad("binary file called CSV", "a.csv", b"\1\0\2\0" * 300 + b"\0\0\0", ("binary", "export it as CSV")),
    Bad(
        "sensor at its end",
        "a.csv",
        table(U_V, CLIPPED_UM),
        (f"line {np.argmax(CLIPPED_UM) + 2}", "displacement_um stays at its highest value 7.5", "drive less, or widen"),
    ),
    Bad("columns exchanged", "a.csv", table(Y_UM, U_V), ("displacement_um runs ahead of voltage_V", "reads them so")),
    # NPZ, MAT, HDF5
    Bad(
        "pickled object", "a.npz", npz(**sound(note=np.array([{}]))), ("array note", "could run code", "plain numbers")
    ),
    Bad("no NPZ", "a.npz", text(), ("is not an NPZ file", "numpy.savez")),
    Bad("damaged NPZ", "a.npz", npz(**sound())[:-3000], ("not an NPZ file", "numpy.savez")),
    Bad("no MAT", "a.mat", text(), ("is not a MAT file of version 4, 5 or 7.3", "save it with")),
    Bad("damaged MAT", "a.mat", mat(**sound())[:900], ("is damaged", "save it again")),  # type: ignore[arg-type]
    Bad("no HDF5", "a.h5", text(), ("is no readable HDF5 file", "write it again")),
    Bad("missing array", "a.h5", hdf5(u=U_V), ("no voltage array 'voltage_V'", "it holds u", "voltage=NAME")),
    Bad(
        "no time at all",
        "a.npz",
        npz(**sound(time_s=None)),
        ("no time array 'time_s'", "it holds", "time=NAME", "--columns Ts_s=SECONDS"),
    ),
    Bad("short aux", "a.npz", npz(**sound(temp=U_V[:9])), ("temp has 9 samples, voltage_V has 400", "leave the")),
    Bad("short time", "a.npz", npz(**sound(time_s=TIME_S[:9])), ("time_s has 9", "voltage_V has 400", "one per")),
    Bad("NaN", "a.npz", npz(**sound(voltage_V=np.where(K == 9, np.nan, U_V))), ("index 9", "voltage_V is nan")),
    Bad("complex numbers", "a.npz", npz(**sound(voltage_V=U_V * 1j)), ("voltage_V holds complex128", "float values")),
    Bad(
        "several axes",
        "a.npz",
        npz(**sound(displacement_um=SPREAD_UM)),
        ("shape (400, 2)", "pick", "'displacement_um[:,0]'"),
    ),
    Bad(
        "index outside",
        "a.npz",
        npz(**sound(displacement_um=SPREAD_UM)),
        ("index 2 in 'displacement_um[:,2]'", "axis 1 of length 2", "count from 0"),
        Columns(displacement="displacement_um[:,2]"),
    ),
]


def one_line(refusal: pytest.ExceptionInfo[RecordError], file: str, says: Sequence[str]) -> str:
    """The message of a refusal: one line that names the file, then says these parts, in this order."""
    message = rest = str(refusal.value)
    assert "\n" not in message
    assert message.startswith(f"{file}: ")
    for part in says:
        assert part in rest, f"'{part}' is not (or not in its place) in: {message}"
        rest = rest.partition(part)[2]
    return message


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: bad.kind)
def test_a_bad_file_of_arrays_is_refused_with_one_line_naming_file_field_and_cure(bad: Bad, tmp_path: Path) -> None:
    path = tmp_path / bad.file
    path.write_bytes(bad.content)
    with pytest.raises(RecordError) as refusal:
        load_record(path, bad.columns)
    one_line(refusal, bad.file, bad.says)


BAD_OPTIONS: list[tuple[str, Callable[[], object], tuple[str, ...]]] = [
    ("unknown unit", lambda: Columns(voltage_unit="Watt"), ("voltage_unit", "'Watt'", "choose from V, mV")),
    ("unknown key", lambda: Columns.from_text("voltge=u"), ("'voltge=u'", "did you mean 'voltage'", "write key=value")),
    ("period that is none", lambda: Columns(Ts_s=-1.0), ("Ts_s: -1 s", "positive number")),
    ("period that is no number", lambda: Columns.from_text("Ts_s=fast"), ("Ts_s 'fast'", "give seconds")),
    ("two-letter separator", lambda: Columns(separator="::"), ("separator: '::'", "choose from comma")),
    ("decimal sign of no kind", lambda: Columns(decimal=";"), ("decimal: ';'", "choose '.' or ','")),
    ("key without value", lambda: Columns.from_text("voltage"), ("'voltage' has no value", "write voltage=NAME")),
    ("no record", Record.joined, ("no record given", "name at least one")),
    ("no segment", lambda: Record.from_segments([], 1e-3), ("arrays: holds no samples", "at least one segment")),
    ("no period", lambda: Record.from_segments([SEGMENT], math.nan), ("Ts_s = nan s", "positive number")),
    ("no frame", lambda: Record.from_dataframe(3), ("a int is no DataFrame", "Record.from_arrays")),
    ("a frame as a file", lambda: load_record(FRAME), ("a DataFrame is no file", "Record.from_dataframe")),
    ("jitter of all", lambda: load_record("a.csv", jitter=1.0), ("jitter: 1 is no share", "0 to below 1")),
    ("no index", lambda: picked(":,x"), ("'x' in 'u[:,x]' is no index", "'a:b'")),
    (
        "one number",
        lambda: picked("0,1"),
        ("picks a single number", "where time runs"),
    ),
    ("few indices", lambda: picked(":"), ("has 1 indices", "2 axes")),
    (
        "index beyond",
        lambda: picked(":,2"),
        ("outside axis 1 of length 2", "from 0"),
    ),
    ("no time", lambda: Record.from_dataframe(FRAME, "time="), ("no sampling period", "Ts_s=SECONDS")),
    (
        "unknown refusal",
        lambda: Record.from_arrays(U_V, Y_UM, 1e-3, accept=["noise"]),
        ("'noise'", "choose from constant"),
    ),
    (
        "arrays: period of zero",
        lambda: Record.from_arrays(U_V, Y_UM, 0.0),
        ("arrays: ", "Ts_s = 0 s", "positive number"),
    ),
    (
        "arrays: lengths",
        lambda: Record.from_arrays(U_V, Y_UM[1:], 1e-3),
        ("displacement_um has 399", "voltage_V has 400"),
    ),
    (
        "arrays: NaN",
        lambda: Record.from_arrays(U_V, Y_UM + [math.nan] * 400, 1e-3),
        ("index 0", "displacement_um is nan"),
    ),
    (
        "arrays: axes",
        lambda: Record.from_arrays(U_V.reshape(2, 200), Y_UM, 1e-3),
        ("voltage_V has shape (2, 200)", "one-dimensional"),
    ),
    ("split nowhere", lambda: Record.from_arrays(U_V, Y_UM, 1e-3).split(1.0), ("split at 1", "between 0 and 1")),
    (
        "rows outside",
        lambda: Record.from_arrays(U_V, Y_UM, 1e-3).rows(0, 401),
        ("rows 0..401", "has 400", "stop <= samples"),
    ),
]


@pytest.mark.parametrize(("make", "says"), [row[1:] for row in BAD_OPTIONS], ids=[row[0] for row in BAD_OPTIONS])
def test_bad_option_is_refused_with_one_line_naming_field_and_cure(
    make: Callable[[], object], says: tuple[str, ...]
) -> None:
    with pytest.raises(RecordError) as refusal:
        make()
    message = str(refusal.value)
    assert "\n" not in message
    for part in says:
        assert part in message


def test_missing_file_and_folder_are_named_with_the_nearest_name(tmp_path: Path) -> None:
    (tmp_path / "ramps.csv").write_bytes(text())
    with pytest.raises(RecordError, match=r"ramp\.csv: there is no such file \(did you mean 'ramps\.csv'\?\)"):
        load_record(tmp_path / "ramp.csv")
    with pytest.raises(RecordError, match="is a folder; name the record in it"):
        load_record(tmp_path)
    (tmp_path / "link.csv").symlink_to("gone.csv")
    with pytest.raises(RecordError, match=r"link\.csv: is a link to gone\.csv, which is not there"):
        load_record(tmp_path / "link.csv")


class Payload:
    """Unpickled, it makes a folder: the proof that code ran."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, (str(self.folder),)


@pytest.mark.parametrize("name", ["voltage_V", "an_array_nobody_asked_for"])
def test_pickled_payload_in_npz_is_refused_and_does_not_run(name: str, tmp_path: Path) -> None:
    proof = tmp_path / "payload-ran"
    path = tmp_path / "a.npz"
    path.write_bytes(npz(**sound(**{name: np.array([Payload(proof)], dtype=object)})))
    with pytest.raises(RecordError, match=f"array {name} is a pickled object, which could run code"):
        load_record(path)
    assert not proof.exists()
    # The payload is live: opened the careless way, the same file runs it.
    with zipfile.ZipFile(path) as archive, archive.open(f"{name}.npy") as member:
        np.lib.format.read_array(member, allow_pickle=True)
    assert proof.exists()


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".mat", ".h5"])
def test_bare_pickle_under_any_suffix_is_refused_and_does_not_run(suffix: str, tmp_path: Path) -> None:
    proof = tmp_path / "payload-ran"
    path = tmp_path / f"a{suffix}"
    path.write_bytes(pickle.dumps(Payload(proof)))
    with pytest.raises(RecordError):
        load_record(path)
    assert not proof.exists()


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("photo.png", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "is a picture; give"),
        ("log.csv", b"%PDF-1.7\n" + bytes(range(256)), "is a PDF; export its table as CSV"),
        (
            "log.xls",
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600),
            "is a document of old Office; save it as .xlsx or CSV",
        ),
        ("log.tar", bytes(257) + b"ustar" + bytes(250), "is a tar archive; unpack it and name the record"),
        ("log.csv.gz", gzip.compress(bytes(257) + b"ustar" + bytes(250), mtime=0), "is a tar archive"),
        ("log.zip", b"PK\x05\x06" + bytes(18), "is an empty zip archive"),
        ("log.pkl", b"\x80\x04\x95" + bytes(40), "is a pickle, which could run code"),
    ],
    ids=["PNG", "PDF", "XLS", "tar", "tar.gz", "zip", "pickle"],
)
def test_a_file_of_another_kind_is_named_by_its_kind(name: str, data: bytes, said: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(RecordError) as caught:
        load_record(tmp_path / name)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("part", ["word/document.xml", "content.xml"])
def test_a_document_in_a_zip_is_named_by_its_kind(part: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "log.docx", "w") as archive:
        archive.writestr("[Content_Types].xml", "<x/>")
        archive.writestr(part, "<x/>")
    with pytest.raises(RecordError, match=r"log\.docx: is (a Word document|an OpenDocument file); save"):
        load_record(tmp_path / "log.docx")


def test_an_address_is_no_file() -> None:
    with pytest.raises(RecordError, match="is an address, not a file; download it first"):
        load_record("https://example.org/log.csv")


def stamped(time_s: np.ndarray) -> Segment:
    return Segment("0", time_s, time_s, stamps_s=time_s, origin=Origin("a.csv", "t", locate=lambda row: f"row {row}"))


@pytest.mark.parametrize(
    ("given_s", "fits"), [(0.989e-3, False), (0.991e-3, True), (1.009e-3, True), (1.011e-3, False)]
)
def test_a_period_that_is_given_agrees_with_the_stamps_within_one_percent(given_s: float, fits: bool) -> None:
    stamps = [stamped(1e-3 * np.arange(50.0))]
    if fits:
        assert sampling_period(stamps, given_s=given_s) == given_s
        return
    with pytest.raises(RecordError, match=f"a.csv: Ts_s = {given_s:g} s was given, but t rises by 0.001 s per row"):
        sampling_period(stamps, given_s=given_s)


@pytest.mark.parametrize(("late", "said"), [(0.049, ""), (0.051, "row 21: t steps by 0.001051 s .* 5.1 % off")])
def test_stamps_are_even_within_a_twentieth_of_the_period(late: float, said: str) -> None:
    t = 1e-3 * np.arange(50.0)
    t[21:] += 1e-3 * late
    stamps = [stamped(t)]
    if not said:
        assert sampling_period(stamps) == pytest.approx(1e-3, rel=2e-3)
        return
    with pytest.raises(RecordError, match=said):
        sampling_period(stamps)


REFUSED = [kind for kind, sample in SAMPLES.items() if "refused" in sample]


def written(kind: str, folder: Path) -> Path:
    path = folder / SAMPLES[kind].get("file", "log.csv")
    path.write_bytes(sample_text(kind))
    return path


@pytest.mark.parametrize("kind", [kind for kind in SAMPLES if kind not in REFUSED])
def test_a_file_is_read_without_options_and_the_option_said_repeats_it(kind: str, tmp_path: Path) -> None:
    path, said = written(kind, tmp_path), SAMPLES[kind].get("said")
    record = load_record(path)
    check(record)
    if said is not None:
        assert any(said in line for line in record.warnings) or (said == "" and record.warnings == ()), record.warnings
    for line in record.warnings:
        if 'read as --columns "' in line:
            again = load_record(path, line.partition('--columns "')[2].rpartition('"')[0])
            assert again.digest == record.digest


@pytest.mark.parametrize("kind", REFUSED)
def test_a_bad_file_is_refused_with_one_line_naming_file_row_field_and_cure(kind: str, tmp_path: Path) -> None:
    path, sample = written(kind, tmp_path), SAMPLES[kind]
    with pytest.raises(RecordError) as refusal:
        load_record(path, sample.get("columns", ""))
    message = one_line(refusal, path.name, sample["refused"])
    if "pasted" in sample:
        check(
            load_record(path, ",".join(filter(None, [message.split('--columns "')[1].split('"')[0], sample["pasted"]])))
        )
