"""A2L: every word of the structs reads back with unit and address from the ELF."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from fixtures.exported_folders import NAME, exported, model
from fixtures.tools import library
from hysgen.checking.proof.eva.boxes import state_box
from hysgen.codegen import tables
from hysgen.codegen.structs import interface
from hysgen.errors import BuildError
from hysgen.export import write_export
from hysgen.export.a2l import LARGEST, Description, Elf, describe, read_elf


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_elf_that_does_not_fit_is_refused(folder: Path, tmp_path: Path) -> None:
    elf = exported(folder, "a2l") / f"{NAME}.elf"
    with pytest.raises(BuildError, match="no such variable; name it with --instance"):
        write_export(model(), "a2l", tmp_path, given={"elf": str(elf), "instance": "other"})
    with pytest.raises(BuildError, match=r"has \d+ bytes in the ELF, \d+ in the model"):
        write_export(model(), "a2l", tmp_path, given={"elf": str(elf), "instance": f"{NAME}_learner"})
    (tmp_path / "text").write_text("no ELF")
    with pytest.raises(BuildError, match="is no ELF file"):
        write_export(model(), "a2l", tmp_path, given={"elf": str(tmp_path / "text")})


def laid_out(base: int = 0x1000, *, little_endian: bool = True, learner: bool = True) -> tuple[Description, Elf]:
    """The description of instance, learner and tables that lie one after the other from `base` on."""
    made, at = interface(model(), inverse=True), base
    sizes = {
        f"{NAME}_instance": made.struct(f"{NAME}_t").bytes,
        f"{NAME}_learner": made.struct(f"{NAME}_learner_t").bytes,
    }
    sizes |= {f"{NAME}_{each.name}": 4 * len(each.values) for each in tables(model())}
    symbols = {}
    for name, size in sizes.items():
        symbols[name] = (at, size)
        at += size
    elf = Elf(symbols, little_endian)
    own = f"{NAME}_learner" if learner else None
    return describe(model(), made, tables(model()), elf, f"{NAME}_instance", own), elf


def test_every_word_has_the_address_of_its_place_in_the_struct() -> None:
    description, elf = laid_out()
    made = interface(model(), inverse=True)
    entries = [entry for entry in (*description.characteristics, *description.measurements) if not entry.mask]
    for variable, owner in ((f"{NAME}_instance", f"{NAME}_t"), (f"{NAME}_learner", f"{NAME}_learner_t")):
        words = list(made.struct(owner).words())
        paths = [word.path for word in words]
        for entry in (entry for entry in entries if entry.name.startswith(f"{variable}.")):
            first = (entry.address - elf.symbols[variable][0]) // 4
            member = entry.name.removeprefix(f"{variable}.")
            assert {
                path.removeprefix(member).rstrip("[]0123456789") for path in paths[first : first + entry.count]
            } == {""}
            assert entry.writable == ("bank[" in member and variable.endswith("instance"))
            assert entry.type == words[first].type
        assert sum(entry.count for entry in entries if entry.name.startswith(f"{variable}.")) == len(paths)
    for table_of_constants in tables(model()):
        (entry,) = (entry for entry in entries if entry.name == f"{NAME}_{table_of_constants.name}")
        assert (entry.address, entry.count) == (elf.symbols[entry.name][0], len(table_of_constants.values))
        inside = (entry.low <= table_of_constants.values) & (table_of_constants.values <= entry.high)
        assert inside.all()
        assert -LARGEST <= entry.low < entry.high <= LARGEST
    assert np.float32(LARGEST) == LARGEST == np.finfo(np.float32).max
    masks = {entry.name: int(entry.mask, 16) for entry in description.measurements if entry.mask}
    assert masks[f"{NAME}_learner.status.RESTARTED"] == 256
    assert masks[f"{NAME}_instance.status.Y_CLAMPED"] == 1
    assert len({method.name for method in description.methods}) == len(description.methods)
    assert {entry.conversion for entry in entries} <= {method.name for method in description.methods}
    assert not any("learner." in entry.name for entry in laid_out(learner=False)[0].measurements)


def test_byte_order_is_the_elfs_and_an_address_fits_into_32_bits() -> None:
    assert laid_out()[0].byte_order == "MSB_LAST"
    description, elf = laid_out(little_endian=False)
    assert description.byte_order == "MSB_FIRST"
    room = sum(size for _, size in elf.symbols.values())
    laid_out((1 << 32) - room)
    with pytest.raises(BuildError, match=r"lies at 0x\w+, beyond the 32 bits of an A2L address"):
        laid_out((1 << 32) - room + 4)


@pytest.mark.parametrize("known", [True, False])
def test_a_program_of_the_user_may_lack_the_learner(
    known: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, elf = laid_out()
    symbols = {name: place for name, place in elf.symbols.items() if known or name != f"{NAME}_learner"}
    monkeypatch.setattr("hysgen.export.a2l.read_elf", lambda _: Elf(symbols, True))
    write_export(model(), "a2l", tmp_path, given={"elf": "own.elf"})
    text = (tmp_path / f"{NAME}.a2l").read_text()
    assert f"{NAME}_instance.y_um" in text
    assert (f"{NAME}_learner." in text) is known
