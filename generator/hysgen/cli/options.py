"""Options that several verbs share: models, folders of generated C, records, and the learner."""

import argparse
import contextlib
import dataclasses
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.display import WRITTEN_IN, Quantities
from hysgen.errors import HysgenError, RecordError
from hysgen.model.file import load_model
from hysgen.model.learner_settings import LEARNED, LearnerSettings
from hysgen.model.model import Model
from hysgen.record import Columns, Record, load_record
from hysgen.record.checks import ACCEPTABLE
from hysgen.record.sampling import JITTER


def add_model(parser: argparse.ArgumentParser, shipped: str = "appendix_a, appendix_b, extended") -> None:
    """MODEL, a file or the name of a shipped model."""
    parser.add_argument("model", metavar="MODEL", help=f"model file, or a shipped one: {shipped}")


def add_predict_only(parser: argparse.ArgumentParser) -> None:
    """--predict-only."""
    parser.add_argument(
        "--predict-only",
        action="store_true",
        help="a hysteresis that may fall where the voltage rises: it predicts, and its C has no inverse",
    )


def add_folder(parser: argparse.ArgumentParser) -> None:
    """DIR, a folder of generated C."""
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")


def add_record_options(parser: argparse.ArgumentParser) -> None:
    """Options of reading records: --columns, --accept, --jitter, --split-at-gaps."""
    parser.add_argument(
        "--columns",
        metavar="KEY=VALUE,...",
        default="",
        help="names, units and separators of the file, as voltage=force_N,displacement=x_nm,separator=tab,Ts_s=2e-5; "
        "keys: "
        f"{', '.join(field.name for field in dataclasses.fields(Columns))} (default: guessed, and said); "
        "aux=NAME once for each further channel, as aux=a,aux=b; input=field [mT],output=angle [deg] for two other "
        "quantities, each with its unit",
    )
    parser.add_argument(
        "--accept", choices=ACCEPTABLE, action="append", default=[], help="take a record in spite of this finding"
    )
    parser.add_argument(
        "--jitter",
        type=float,
        default=JITTER,
        metavar="PART",
        help="deviation of a time stamp that is let through, as a part of the sampling period (default %(default)g)",
    )
    parser.add_argument(
        "--split-at-gaps", action="store_true", help="make segments where time has gaps, instead of refusing"
    )


BIG_BYTES = 10_000_000
"""Size from which on it is said that files are being read: a second of text, and more of what is packed."""


def says_reading(files: Sequence[Path], console: Console) -> bool:
    """Whether the files are so big that it was said that they are being read."""
    size = sum(file.stat().st_size for file in files if file.is_file())
    if size >= BIG_BYTES:
        console.progress(0.0, f"reading {size / 1e6:.0f} MB")
    return size >= BIG_BYTES


def read_records(
    paths: list[str], arguments: argparse.Namespace, console: Console, echo: bool = True, gated: bool = False
) -> Record:
    """The records at `paths`, joined as segments of one record; warnings go to stderr.

    echo: print one line with rate, duration and ranges. gated: see `Record.without_wrong_readings`.
    """
    columns = Columns.from_text(arguments.columns) if arguments.columns else Columns()
    with tempfile.TemporaryDirectory() as folder:
        files = [_from_stdin(Path(folder)) if path == "-" else Path(path) for path in paths]
        big = says_reading(files, console)
        record = load_record(
            files,
            columns.of(WRITTEN_IN.get()),
            jitter=arguments.jitter,
            accept=arguments.accept,
            split_at_gaps=arguments.split_at_gaps,
            # The rows that a diagnosis does not identify on are held out, and wanted.
            upto=None if gated else _stop_of(getattr(arguments, "rows", None)),
        )
    record = record.without_wrong_readings(gated)
    if big:
        console.progress(1.0, f"{record.samples} rows are read")
    for warning in record.warnings:
        console.warn(warning)
    if echo:
        console.say(record.one_line())
    return record


def quantities_of(arguments: argparse.Namespace) -> Quantities:
    """The quantities that a call is about: those of --columns, else of the first model or folder of C that it names."""
    with contextlib.suppress(HysgenError, OSError, StopIteration, IndexError):
        if (stated := Columns.from_text(getattr(arguments, "columns", "")).quantities).other:
            return stated
        named = [getattr(arguments, name, None) for name in ("model", "old", "folder")]
        named += getattr(arguments, "files", [])
        place = Path(next(name for name in named if name))
        from hysgen.codegen.manifest import MANIFEST  # imports all that writes C

        inside = sorted(path for path in place.glob("*.json") if path.name != MANIFEST) if place.is_dir() else [place]
        return load_model(inside[-1]).quantities
    return Quantities()


def _from_stdin(folder: Path) -> Path:
    """What stdin holds, as a file: readers of other formats need to move in it."""
    path = folder / "stdin"
    path.write_bytes(sys.stdin.buffer.read())
    return path


def _stop_of(rows: str | None) -> int | None:
    """B of rows "A:B", if it is a number of rows."""
    stop = (rows or "").rpartition(":")[2].strip()
    return int(stop) if stop.isdecimal() and int(stop) else None


def parse_rows(text: str, samples: int, Ts_s: float) -> tuple[int, int]:
    """(A, B) of rows "A:B", counted from 0, B excluded; an empty A or B means the end of the record.

    A number that ends in s or ms is a time after the first row; a negative one counts from the end.
    Raises RecordError if the text is no range within the record.

    >>> parse_rows("5000:", 7100, 1e-3), parse_rows("0.5s:-100", 7100, 1e-3)
    ((5000, 7100), (500, 7000))
    """
    first, colon, last = text.partition(":")

    def row(part: str, empty: int) -> int:
        part = part.strip()
        scale = 1e-3 if part.endswith("ms") else 1.0
        number = round(scale * float(part.rstrip("ms")) / Ts_s) if part.endswith("s") else int(part or empty)
        return number + samples if number < 0 else number

    try:
        start, stop = row(first, 0), row(last, samples)
    except ValueError:
        colon = ""
        start = stop = 0
    if not colon or not 0 <= start < stop <= samples:
        raise RecordError(
            f"rows: '{text}' is not a range of the record's {samples} samples; write FIRST:LAST, as 0:5000 or 0s:0.1s"
        )
    return start, stop


def add_learner_options(parser: argparse.ArgumentParser) -> None:
    """--learn and the settings of the learner."""
    defaults = LearnerSettings()
    group = parser.add_argument_group("online learning (docs/learning.md)")
    group.add_argument(
        "--learn",
        choices=(*LEARNED, "none"),
        help="parameters that the generated C learns: consequents of the rules, only their gains, one bias, or none"
        " (default: what the model file says)",
    )
    group.add_argument(
        "--learn-forgetting",
        type=float,
        metavar="LAMBDA",
        help=f"forgetting factor of the learner, 0.9 to 1 (default {defaults.forgetting})",
    )
    group.add_argument(
        "--learn-alpha",
        type=float,
        metavar="ALPHA",
        help=f"P(0) = alpha I of the learner; it starts from the identified parameters (default {defaults.alpha:g})",
    )
    group.add_argument(
        "--learn-noise",
        type=float,
        metavar="UM",
        help=f"rms noise of the sensor in um: sets dead zone and outlier gate (default {defaults.noise_um:g})",
    )


def with_learner(model: Model, arguments: argparse.Namespace) -> Model:
    """The model with the learner that the options describe; unchanged without options.

    Raises ModelError if a value is outside its range.
    """
    given = {
        "forgetting": arguments.learn_forgetting,
        "alpha": arguments.learn_alpha,
        "noise_um": arguments.learn_noise,
    }
    changes = {name: value for name, value in given.items() if value is not None}
    if arguments.learn == "none":
        return dataclasses.replace(model, learner=None)
    if arguments.learn is not None:
        changes["learned"] = LEARNED[arguments.learn]
    elif not changes:
        return model
    return dataclasses.replace(model, learner=dataclasses.replace(model.learner or LearnerSettings(), **changes))
