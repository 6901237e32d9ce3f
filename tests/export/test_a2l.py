"""A2L: every word of the structs reads back with unit and address from the ELF."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pytest

from fixtures.exported_folders import NAME, exported, model
from fixtures.tools import library
from hysgen.checking.proof.eva.banks import state_box
from hysgen.errors import BuildError
from hysgen.export import A2lSource, write_export
from hysgen.export.a2l import read_elf


def test_a2l_reads_back_with_every_word_unit_and_address(folder: Path) -> None:
    """Read by pya2l. Every word of a struct has one entry; a table at its address holds the model's numbers."""
    library("pya2l")
    from pya2l.parser import A2lParser

    here = exported(folder, "a2l")
    with A2lParser() as parser:
        module = parser.tree_from_a2l((here / f"{NAME}.a2l").read_bytes()).PROJECT.MODULE[0]
    elf = read_elf(here / f"{NAME}.elf")
    words: dict[int, str] = {}
    for kind in (module.CHARACTERISTIC, module.MEASUREMENT):
        for entry in kind:
            if entry.HasField("BIT_MASK"):
                continue
            address = entry.ECU_ADDRESS.Address.Value if kind is module.MEASUREMENT else entry.Address.Value
            count = 1
            if entry.HasField("MATRIX_DIM"):
                count = entry.MATRIX_DIM.XDim.Value
            elif kind is module.CHARACTERISTIC and entry.AXIS_DESCR:
                count = entry.AXIS_DESCR[0].MaxAxisPoints.Value
            for word in range(count):
                assert address + 4 * word not in words
                words[address + 4 * word] = entry.Name.Value
            assert entry.LowerLimit.Value < entry.UpperLimit.Value
    for variable in ("instance", "learner"):
        start, size = elf.symbols[f"{NAME}_{variable}"]
        assert all(words[start + at].startswith(f"{NAME}_{variable}.") for at in range(0, size, 4))
    units = {method.Name.Value: method.Unit.Value for method in module.COMPU_METHOD}
    measured = {entry.Name.Value: entry for entry in module.MEASUREMENT}
    assert units[measured[f"{NAME}_instance.y_um"].Conversion.Value] == "um"
    assert units[measured[f"{NAME}_instance.u_V"].Conversion.Value] == "V"
    assert measured[f"{NAME}_instance.status.U_CLAMPED"].BIT_MASK.Mask.Value == 2
    box = state_box(model())["y_um"]
    limits = measured[f"{NAME}_instance.y_um"]
    assert (limits.LowerLimit.Value, limits.UpperLimit.Value) == pytest.approx((box.low, box.high)), "of any commit"
    assert units[measured[f"{NAME}_instance.inputs.creep.high"].Conversion.Value] == "um", "behind the hysteresis"
    assert measured[f"{NAME}_learner.fresh"].UpperLimit.Value == 1, "a flag"
    assert measured[f"{NAME}_learner.theta"].UpperLimit.Value < 1e30, "the limit of a parameter"
    written = {entry.Name.Value: entry for entry in module.CHARACTERISTIC}
    assert units[written[f"{NAME}_delay_part"].Conversion.Value] == "samples"
    assert units[written[f"{NAME}_drift_limit"].Conversion.Value] == "um"
    bank = written[f"{NAME}_instance.bank[1].gain"]
    assert (units[bank.Conversion.Value], bank.AXIS_DESCR[0].MaxAxisPoints.Value) == ("um/um", 2)
    assert not bank.HasField("READ_ONLY")
    assert written[f"{NAME}_gain"].HasField("READ_ONLY")
    centres = next(entry for entry in module.CHARACTERISTIC if entry.Name.Value == f"{NAME}_strength").AXIS_DESCR[0]
    assert [point.Value for point in centres.FIX_AXIS_PAR_LIST.AxisPtsValue] == pytest.approx(model().grid.centres_um)
    assert table(here / f"{NAME}.elf", elf.symbols[f"{NAME}_strength"]) == table_of(here, "strength")


def table(path: Path, symbol: tuple[int, int]) -> tuple[int, ...]:
    """The words of a symbol in the file of an ELF."""
    from elftools.elf.elffile import ELFFile

    with path.open("rb") as stream:
        for segment in ELFFile(stream).iter_segments("PT_LOAD"):
            offset = symbol[0] - segment["p_vaddr"]
            if 0 <= offset < segment["p_filesz"]:
                return struct.unpack(f"<{symbol[1] // 4}I", segment.data()[offset : offset + symbol[1]])
    raise AssertionError("the symbol lies in no segment")


def table_of(here: Path, name: str) -> tuple[int, ...]:
    """The words of a table in the text of <name>_params.h."""
    text = (here / "model" / f"{NAME}_params.h").read_text()
    body = text.partition(f"{NAME}_{name}[")[2].partition("};")[0]
    numbers = re.findall(r"(-?[\d.]+(?:e[-+]\d+)?)f,", body)
    return tuple(struct.unpack("<I", struct.pack("<f", float(number)))[0] for number in numbers)


def test_an_elf_that_does_not_fit_is_refused(folder: Path, tmp_path: Path) -> None:
    elf = exported(folder, "a2l") / f"{NAME}.elf"
    with pytest.raises(BuildError, match="no such variable; name it with --instance"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(elf, "other"))
    with pytest.raises(BuildError, match=r"has \d+ bytes in the ELF, \d+ in the model"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(elf, f"{NAME}_learner"))
    (tmp_path / "text").write_text("no ELF")
    with pytest.raises(BuildError, match="is no ELF file"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(tmp_path / "text"))
