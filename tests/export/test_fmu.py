"""FMUs of FMI 2.0 and 3.0: valid, with a state that is saved and restored, and events for the status word."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.exported_folders import NAME, exported, model
from fixtures.tools import library
from hysgen.codegen import Options
from hysgen.errors import HysgenError
from hysgen.export.check import Reference, inputs
from hysgen.export.component import MODES
from hysgen.export.fmu import archive, run_fmu


@pytest.mark.parametrize("standard", [2, 3])
@pytest.mark.slow
def test_an_fmu_is_valid_and_holds_nothing_of_python(standard: int, folder: Path) -> None:
    here = exported(folder, "fmu")
    library("fmpy")
    from fmpy.validation import validate_fmu

    path = here / f"{NAME}_fmi{standard}.fmu"
    assert validate_fmu(str(path)) == []
    texts = {file.relative_to(here).as_posix(): file.read_text() for file in here.rglob("*.[chx]*") if file.is_file()}
    assert archive(standard, NAME, texts) == path.read_bytes(), "the same sources make the same archive"
    content = subprocess.run(["ldd", _binary(path, here)], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"^\s+(\S+?)\.so", content, re.M)) <= {"linux-vdso", "libc", "/lib64/ld-linux-x86-64"}


def _binary(path: Path, here: Path) -> str:
    """The path of the shared library of an FMU, unpacked."""
    target = here / "unpacked" / path.stem
    shutil.unpack_archive(path, target, "zip")
    return str(next((target / "binaries").rglob(f"{NAME}.so")))


@pytest.mark.parametrize("standard", [2, 3])
def test_an_fmu_saves_restores_and_resets_its_state(standard: int, folder: Path) -> None:
    """The same samples after a restore of the state in memory, of its bytes, and after a reset."""
    path = exported(folder, "fmu")
    library("fmpy")
    fmu, names = opened(standard, path)
    first = stepped(standard, fmu, names, 50)
    state = (fmu.getFMUstate if standard == 2 else fmu.getFMUState)()
    data = (fmu.serializeFMUstate if standard == 2 else fmu.serializeFMUState)(state)
    ahead = stepped(standard, fmu, names, 50)
    assert not np.array_equal(ahead, first)
    (fmu.setFMUstate if standard == 2 else fmu.setFMUState)(state)
    assert np.array_equal(stepped(standard, fmu, names, 50), ahead)
    back = (fmu.deSerializeFMUstate if standard == 2 else fmu.deserializeFMUState)(data)
    (fmu.setFMUstate if standard == 2 else fmu.setFMUState)(back)
    assert np.array_equal(stepped(standard, fmu, names, 50), ahead)
    fmu.reset()
    begun(standard, fmu, names)
    assert np.array_equal(stepped(standard, fmu, names, 50), first)
    with pytest.raises(Exception, match="DoStep"):
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=1.5 * model().Ts_s)
    if standard == 2:
        fmu.getString([])
        fmu.setString([], [])
    for call in (fmu.getString, fmu.getReal if standard == 2 else fmu.getFloat32):
        with pytest.raises(Exception, match="Get"):
            call([10_000])
    fmu.terminate()
    fmu.freeInstance()


def test_a_status_bit_of_the_fmu_is_an_event(folder: Path) -> None:
    """FMI 3.0: a step of 100 samples ends early where the voltage leaves its range; outputs follow in event mode."""
    path = exported(folder, "fmu")
    library("fmpy")
    fmu, names = opened(3, path, events=True)
    fmu.enterStepMode()
    quiet = fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=100 * model().Ts_s)
    assert quiet[0] in (0, False)
    before = fmu.getUInt32([names["status"]])[0]
    fmu.setFloat32([names["u_V"]], [1e6])
    event, _, early, last = fmu.doStep(
        currentCommunicationPoint=100 * model().Ts_s, communicationStepSize=100 * model().Ts_s
    )
    assert (bool(event), bool(early)) == (True, True)
    assert last == pytest.approx(101 * model().Ts_s)
    assert fmu.getUInt32([names["status"]])[0] == before
    fmu.enterEventMode()
    assert fmu.getBoolean([names["u_clamped"]])[0]
    fmu.terminate()
    fmu.freeInstance()


def opened(standard: int, path: Path, *, events: bool = False) -> tuple[Any, dict[str, int]]:
    """An instance of the FMU in mode simulate, initialised, and the references of its variables."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    file = str(path / f"{NAME}_fmi{standard}.fmu")
    description = fmpy.read_model_description(file)
    names = {variable.name: variable.valueReference for variable in description.modelVariables}
    kind = FMU2Slave if standard == 2 else FMU3Slave
    fmu = kind(guid=description.guid, unzipDirectory=fmpy.extract(file), modelIdentifier=NAME, instanceName="test")
    fmu.instantiate(**({"eventModeUsed": True, "earlyReturnAllowed": True} if events else {}))
    begun(standard, fmu, names)
    return fmu, names


def begun(standard: int, fmu: Any, names: dict[str, int]) -> None:
    if standard == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


def stepped(standard: int, fmu: Any, names: dict[str, int], n: int) -> np.ndarray:
    """Outputs of n steps under a ramp of the voltage that starts anew with every call."""
    set_float, get_float = (fmu.setReal, fmu.getReal) if standard == 2 else (fmu.setFloat32, fmu.getFloat32)
    out = []
    for k in range(n):
        set_float([names["u_V"]], [30.0 + 0.2 * k])
        fmu.doStep(currentCommunicationPoint=k * model().Ts_s, communicationStepSize=model().Ts_s)
        out.append(get_float([names["y_model_um"]])[0])
    return np.array(out)


def test_the_comparison_sees_a_missing_fmu(folder: Path, tmp_path: Path) -> None:
    exported(folder, "fmu")
    with pytest.raises(HysgenError, match="is missing; this is not a folder"):
        run_fmu(2, model(), tmp_path, inputs(Reference.compile(model(), Options()), MODES[0], 10))
