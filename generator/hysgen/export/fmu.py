"""FMUs for FMI 2.0 and 3.0, co-simulation: variables, files, binary for this machine, archive."""

import functools
import io
import platform
import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from hysgen.codegen import Options
from hysgen.codegen.manifest import NAMES_HOLD, c_files, read_folder
from hysgen.codegen.parameters import literal
from hysgen.errors import BuildError
from hysgen.export.base import Draft, Export, Samples, Words, Written, component_facts, component_texts
from hysgen.machine.files import data_folder, digest, write_whole
from hysgen.machine.kernel_build import export_flags
from hysgen.machine.native import default_toolchain
from hysgen.model.model import Model
from hysgen.model.structs import Status

HEADERS: Final = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
"""Headers of the FMI standard; each states its 2-clause BSD licence."""

_SOURCES: Final = {
    "{name}_fmu.h": "fmu_core.h",
    "{name}_fmu.c": "fmu_core.c",
    "{name}_fmi2.c": "fmu2.c",
    "{name}_fmi3.c": "fmu3.c",
}
README: Final = """\
    make example           # both FMUs in FMPy: validation and a run
    make                   # compile and pack again, for example on another machine

{{ name }}_fmi2.fmu (FMI 2.0) and {{ name }}_fmi3.fmu (FMI 3.0), co-simulation: source code and a binary for the
machine that made them; no Python, no library inside. `mode` is a fixed parameter. A communication step is a multiple
of the sample period; inputs are held over it. State can be read, written, serialised; reset starts anew. In FMI 3.0 a
change of `status` is an event (event mode, early return); in FMI 2.0, which has no events in co-simulation, the bits
are Boolean outputs. `u_command_V` after a step from t is the command of the sample at t. The headers fmi2*.h and
fmi3*.h are those of the FMI standard, under the 2-clause BSD licence in them.
"""

_FLAGS: Final = ("-std=c99", "-O2", "-fPIC", "-ffp-contract=off", "-fvisibility=hidden", "-shared")
_UNITS: Final = (
    '<Unit name="um"><BaseUnit m="1" factor="1e-6"/></Unit>',
    '<Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>',
)

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every file in an archive, so that equal files make equal archives."""


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU. kind: float, word (32-bit integer) or boolean.

    member: C path in `<name>_fmu_t`; mask: bit of it that a Boolean shows, as C text, "" for the whole word.
    start, low, high: as XML text; start is None for an output, low "" without limits.
    """

    reference: int
    index: int
    name: str
    kind: str
    causality: str
    variability: str
    about: str
    member: str
    start: str | None = None
    unit: str = ""
    low: str = ""
    high: str = ""
    mask: str = ""

    @property
    def settable(self) -> bool:
        return self.causality in ("parameter", "input")

    @property
    def initial(self) -> str:
        """Value of the attribute `initial`, "" for none: an input has none."""
        return {"parameter": "exact", "output": "calculated"}.get(self.causality, "")

    @property
    def type3(self) -> str:
        """Type in FMI 3.0."""
        return {"float": "Float32", "word": "UInt32", "boolean": "Boolean"}[self.kind]

    @property
    def c_start(self) -> str:
        """Start value as C."""
        return literal(np.float32(float(self.start or 0))) if self.kind == "float" else f"{self.start}u"


def variables(model: Model, facts: Mapping[str, Any]) -> list[Variable]:
    """The variables of the FMU, in the order of its description."""
    listed: list[Variable] = []

    def add(name: str, kind: str, causality: str, about: str, **more: Any) -> None:
        variability = more.pop("variability", "continuous" if kind == "float" else "discrete")
        place = len(listed) + 1
        listed.append(
            Variable(place, place, name, kind, causality, variability, about, more.pop("member", name), **more)
        )

    modes = ", ".join(f"{mode.number}: {mode.name}" for mode in facts["modes"])
    y = {"unit": "um", "start": facts["rest_um"]}
    u = {"unit": "V", "start": facts["middle_V"]}
    fixed = {"variability": "fixed"}
    last = str(facts["modes"][-1].number)
    add("mode", "word", "parameter", modes, start="1", low="0", high=last, **fixed)
    add("y0_um", "float", "parameter", "displacement at the start", **y, **fixed)
    add("u0_V", "float", "parameter", "voltage at the start", **u, **fixed)
    add("y_um", "float", "input", "measured displacement y(k); not used by simulate", **y)
    add("u_V", "float", "input", "voltage u(k); not used by inverse", **u)
    if facts["inverse"]:
        add("y_next_um", "float", "input", "reference y(k+1) of mode inverse", **y)
    if facts["learns"]:
        add("commit", "boolean", "input", "mode learn: begin to commit what was learned", start="false")
    middles = [m for term in model.terms for m in getattr(term, "middle", [])]
    for c, channel in enumerate(model.channels):
        name = "aux_" + re.sub(r"\W", "_", channel)
        start = repr(float(middles[c])) if c < len(middles) else "0.0"
        add(name, "float", "input", f"auxiliary channel {channel}", member=f"aux[{c}]", start=start)
    add("y_model_um", "float", "output", "displacement y(k+1) of the model", unit="um")
    add("u_command_V", "float", "output", "voltage of the sample: of the inverse, or the accepted input", unit="V")
    add("status", "word", "output", "status bits; those of the learner shifted left by 16")
    if facts["learns"]:
        add("answer", "word", "output", "answer of the last call of commit")
    for flag in Status.of(model.responds):
        add(str(flag.name).lower(), "boolean", "output", flag.meaning, member="status", mask=f"0x{int(flag):x}u")
    return listed


def token(texts: Mapping[str, str]) -> str:
    """The identity of the FMU: a UUID made of the digest of all files of the generated folder."""
    d = digest("".join(f"{name}\n{texts[name]}" for name in sorted(texts)).encode())
    return f"{{{d[:8]}-{d[8:12]}-{d[12:16]}-{d[16:20]}-{d[20:32]}}}"


def facts_of(draft: Draft) -> dict[str, Any]:
    """The template variables of both FMUs beside those of the component."""
    name = draft.model.name
    own = [f"{name}_fmu.c", f"{name}_component.c", f"{name}.c"]
    stated = draft.model.quantities
    return {
        "names_hold": NAMES_HOLD if stated.other else "",
        "units": [f'<Unit name="{unit}"/>' for unit in dict.fromkeys(stated.units)] if stated.other else _UNITS,
        "variables": variables(draft.model, draft.facts),
        "token": token(draft.generated),
        "sources2": [f"{name}_fmi2.c", *own],
        "sources3": [f"{name}_fmi3.c", *own],
    }


def headers(standard: int) -> dict[str, str]:
    """The headers of the FMI standard by name."""
    folder = data_folder("templates", holds="source.c.j2") / "export" / "fmi"
    return {name: (folder / name).read_text(encoding="utf-8") for name in HEADERS[standard]}


def archive(standard: int, name: str, files: Mapping[str, str]) -> bytes:
    """The .fmu: description, sources, binary for this machine. files: texts of the export folder by path.

    Raises BuildError without a compiler.
    """
    sources = {Path(path).name: text for path, text in files.items() if path.startswith(f"sources{standard}/")}
    content: dict[str, bytes] = {f"sources/{file}": text.encode() for file, text in sources.items()}
    content["modelDescription.xml"] = files[f"modelDescription{standard}.xml"].encode()
    if standard == 3:
        content["sources/buildDescription.xml"] = files["buildDescription3.xml"].encode()
    library, system = _library(standard)
    content[f"binaries/{system}/{name}{library}"] = _binary(standard, sources)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as bundle:
        for path in sorted(content):
            bundle.writestr(zipfile.ZipInfo(path, _EPOCH), content[path], zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def sources(draft: Draft) -> dict[str, str]:
    """Path in the export folder -> text of the sources of both FMUs: model, component, FMU, headers of the standard."""
    own = {**c_files(draft.generated), **component_texts(draft.facts), **draft.rendered(_SOURCES)}
    left_out = ("_selftest.c", "_selftest.h", "_selftest_data.h")
    return {
        f"sources{standard}/{file}": text
        for standard in (2, 3)
        for file, text in {**own, **headers(standard)}.items()
        if not file.endswith((*left_out, f"_fmi{5 - standard}.c"))
    }


def finish(written: Written) -> list[str]:
    """Write both archives. Raises BuildError without a compiler."""
    name = written.draft.model.name
    archives = {f"{name}_fmi{standard}.fmu": archive(standard, name, written.texts) for standard in (2, 3)}
    for path, data in archives.items():
        write_whole(written.folder / path, data)
    return list(archives)


def _library(standard: int) -> tuple[str, str]:
    """(suffix of a shared library, name of this platform in FMI)."""
    suffix = {"darwin": ".dylib", "win32": ".dll"}.get(str(sys.platform), ".so")
    if standard == 2:
        return suffix, {"darwin": "darwin64", "win32": "win64"}.get(str(sys.platform), "linux64")
    machine = platform.machine().lower()
    system = {"darwin": "darwin", "win32": "windows"}.get(str(sys.platform), "linux")
    return suffix, f"{ {'amd64': 'x86_64', 'arm64': 'aarch64'}.get(machine, machine) }-{system}"


def _binary(standard: int, sources: Mapping[str, str]) -> bytes:
    compiler = default_toolchain()
    with tempfile.TemporaryDirectory() as scratch:
        for file, text in sources.items():
            Path(scratch, file).write_text(text, encoding="utf-8", newline="\n")
        units = sorted(file for file in sources if file.endswith(".c"))
        call = [*compiler.call, *_FLAGS, *export_flags([f"fmi{standard}*"], Path(scratch)), "-o", "fmu.bin", *units]
        run = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            raise BuildError(f"{compiler.command}: {(run.stderr.strip().splitlines() or ['no message'])[0]}")
        return Path(scratch, "fmu.bin").read_bytes()


def run_fmu(standard: int, model: Model, folder: Path, samples: Samples) -> Words:
    """An FMU in FMPy, one communication step per sample."""
    try:
        import fmpy
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave
    except ImportError as fault:
        raise BuildError("FMPy is not installed: pip install 'hysgen[export]'") from fault
    options = Options(inverse=bool(read_folder(folder / "model").facts["options"]["inverse"]))
    by_name = {variable.name: variable for variable in variables(model, component_facts(model, options))}
    path = str(folder / f"{model.name}_fmi{standard}.fmu")
    description = fmpy.read_model_description(path)
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        fmpy.extract(path, scratch)
        kind = FMU2Slave if standard == 2 else FMU3Slave
        fmu = kind(
            guid=description.guid,
            unzipDirectory=scratch,
            modelIdentifier=model.name,
            instanceName="check",
        )
        fmu.instantiate()
        try:
            return _stepped(standard, fmu, by_name, model, samples)
        finally:
            fmu.terminate()
            fmu.freeInstance()


def _stepped(standard: int, fmu: Any, by_name: Mapping[str, Variable], model: Model, samples: Samples) -> Words:
    """Results and status words of every sample of an instantiated FMU."""
    set_float, set_word, get_float, get_word = (
        (fmu.setReal, fmu.setInteger, fmu.getReal, fmu.getInteger)
        if standard == 2
        else (fmu.setFloat32, fmu.setUInt32, fmu.getFloat32, fmu.getUInt32)
    )
    inverts = samples.mode.name == "inverse"
    references = [by_name[name].reference for name in ("y_um", "y_next_um" if inverts else "u_V")]
    references += [variable.reference for variable in by_name.values() if variable.member.startswith("aux[")]
    result = [by_name["u_command_V" if inverts else "y_model_um"].reference]
    status = [by_name["status"].reference]
    if standard == 2:
        fmu.setupExperiment(startTime=0.0)
    set_word([by_name["mode"].reference], [samples.mode.number])
    set_float(
        [by_name["y0_um"].reference, by_name["u0_V"].reference],
        [float(samples.y0_um), float(samples.u0_V)],
    )
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    values = samples.rows[:, :-1].copy().view(np.float32).astype(float).tolist()
    commits = samples.commit.tolist()
    learns = samples.mode.name == "learn"
    out = np.empty((len(values), 2), np.uint32)
    results = np.empty(len(values), np.float32)
    for k, row in enumerate(values):
        set_float(references, row)
        if learns:
            fmu.setBoolean([by_name["commit"].reference], [bool(commits[k])])
        fmu.doStep(currentCommunicationPoint=k * model.Ts_s, communicationStepSize=model.Ts_s)
        results[k] = get_float(result)[0]
        out[k, 1] = get_word(status)[0] & 0xFFFFFFFF
    out[:, 0] = results.view(np.uint32)
    return out


EXPORT = Export(
    "fmu",
    "FMUs for FMI 2.0 and 3.0",
    files={
        "modelDescription2.xml": "fmu2.xml",
        "modelDescription3.xml": "fmu3.xml",
        "buildDescription3.xml": "fmu3_build.xml",
        "Makefile": "fmu_Makefile",
        "example.py": "fmu_example.py",
    },
    readme=README,
    ways={"FMI 2.0": functools.partial(run_fmu, 2), "FMI 3.0": functools.partial(run_fmu, 3)},
    facts=facts_of,
    sources=sources,
    finish=finish,
)
