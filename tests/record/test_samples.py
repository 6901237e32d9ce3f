"""Text files of instruments, loggers, spreadsheets and programs: each is read and said, or refused with row and cure.

samples.toml holds one file a kind. `said`: part of a remark of the reading, nothing for none. `refused`: parts of the
message in their order; what it says to paste reads the file, with `pasted` behind it, where the sample has this field.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from fixtures.record_of_files import SAMPLES, check, sample_text
from hysgen.errors import RecordError
from hysgen.record import load_record

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
    message = str(refusal.value)
    assert "\n" not in message
    assert message.startswith(f"{path.name}: ")
    rest = message
    for part in sample["refused"]:
        assert part in rest, f"'{part}' is not (or not in its place) in: {message}"
        rest = rest.partition(part)[2]
    if "pasted" in sample:
        check(
            load_record(path, ",".join(filter(None, [message.split('--columns "')[1].split('"')[0], sample["pasted"]])))
        )
