"""Folders that bring a model into other tools: Simulink, FMI, XCP, CMake, a shared library, a Cortex-M.

Each folder holds the generated C in model/, the files of its target, a build and an example. `export_texts` returns the
texts; `write_export` writes them, and compiles what the target ships as a binary.
"""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.codegen import Options, generate, tables
from hysgen.codegen.parameters import numbers_digest_of
from hysgen.codegen.render import render
from hysgen.codegen.structs import interface
from hysgen.errors import BuildError, HysgenError
from hysgen.export.a2l import Description, describe, read_elf
from hysgen.export.component import component_facts, component_texts
from hysgen.export.fmu import archive, fmu_facts, fmu_sources
from hysgen.machine.files import write_whole
from hysgen.machine.native import default_toolchain
from hysgen.model.model import Model
from hysgen.model.path import preview

TARGETS: Final = {
    "sfunction": "Simulink S-function and MEX gateway",
    "fmu": "FMUs for FMI 2.0 and 3.0",
    "a2l": "A2L description for XCP",
    "cmake": "CMake package",
    "shared": "Shared library",
    "cortexm": "Cortex-M example",
}
"""Name of a target on the command line -> what its folder is."""

_FILES: Final[dict[str, dict[str, str]]] = {
    "sfunction": {
        "{name}_sfun.c": "sfunction.c",
        "{name}_mex.c": "mex.c",
        "{name}_make.m": "sfunction_make.m",
        "{name}_example.m": "sfunction_example.m",
        "Makefile": "sfunction_Makefile",
        "standin/simstruc.h": "simstruc.h",
        "standin/cg_sfun.h": "cg_sfun.h",
        "standin/run.c": "standin.c",
    },
    "fmu": {
        "modelDescription2.xml": "fmu2.xml",
        "modelDescription3.xml": "fmu3.xml",
        "buildDescription3.xml": "fmu3_build.xml",
        "Makefile": "fmu_Makefile",
        "example.py": "fmu_example.py",
    },
    "a2l": {"{name}_ecu.c": "a2l_ecu.c", "Makefile": "a2l_Makefile"},
    "cmake": {
        "CMakeLists.txt": "cmake_CMakeLists.txt",
        "consumer/CMakeLists.txt": "cmake_consumer.txt",
        "run.c": "run.c",
    },
    "shared": {
        "{name}_shared.h": "shared.h",
        "{name}_shared.c": "shared.c",
        "Makefile": "shared_Makefile",
        "CMakeLists.txt": "shared_CMakeLists.txt",
        "example.py": "shared_example.py",
    },
    "cortexm": {
        "main.c": "cortexm_main.c",
        "start.c": "cortexm_start.c",
        "link.ld": "cortexm_link.ld",
        "Makefile": "cortexm_Makefile",
    },
}
"""Target -> path in its folder -> template in templates/export/."""

_FMU: Final = {
    "{name}_fmu.h": "fmu_core.h",
    "{name}_fmu.c": "fmu_core.c",
    "{name}_fmi2.c": "fmu2.c",
    "{name}_fmi3.c": "fmu3.c",
}


@dataclass(frozen=True)
class A2lSource:
    """The ELF that an A2L file describes. elf: path, None: the example of the folder, linked here.

    instance, learner: variables of the types `<name>_t` and `<name>_learner_t`; "": those of the example.
    """

    elf: Path | None = None
    instance: str = ""
    learner: str = ""


def export_texts(model: Model, target: str, options: Options | None = None) -> dict[str, str]:
    """The text of every file of the folder, by its path there; binaries and the A2L file are not among them.

    Raises HysgenError for an unknown target, and the errors of `generate`.
    """
    if target not in TARGETS:
        raise HysgenError(f"{target}: not a target of export; choose {', '.join(TARGETS)}")
    chosen = options or Options()
    generated = generate(model, chosen)
    facts: dict[str, Any] = {**component_facts(model, chosen), "target": target, "title": TARGETS[target]}
    facts["preview"] = preview(model.blocks) if chosen.inverse else 0
    if target == "fmu":
        facts = fmu_facts(model, facts, generated)
    files = _FILES[target]
    texts = {f"model/{file}": text for file, text in generated.items()}
    texts |= {path.format(name=model.name): render(f"export/{file}.j2", facts) for path, file in files.items()}
    component = {file: render(template, facts) for file, template in component_texts(facts).items()}
    if target == "fmu":
        own = {path.format(name=model.name): render(f"export/{file}.j2", facts) for path, file in _FMU.items()}
        for standard in (2, 3):
            texts |= fmu_sources(standard, generated, {**component, **own})
    elif target != "a2l":
        texts |= component
    if target != "a2l":
        texts["README.md"] = render("export/README.md.j2", facts)
    return texts


def write_export(
    model: Model, target: str, folder: Path, options: Options | None = None, source: A2lSource | None = None
) -> list[Path]:
    """Write the folder of `target`, with its binaries. Returns the paths in the order of writing.

    source: the ELF of an A2L file. Raises the errors of `export_texts`, and BuildError where a compiler is missing or
    the ELF does not fit the model.
    """
    texts = export_texts(model, target, options)
    content: dict[str, str | bytes] = dict(texts)
    if target == "fmu":
        content |= {f"{model.name}_fmi{s}.fmu": archive(s, model.name, texts) for s in (2, 3)}
    for path, data in content.items():
        write_whole(folder / path, data)
    if target == "shared":
        _make(folder, f"lib{model.name}.so")
        content[f"lib{model.name}.so"] = b""
    if target == "a2l":
        for path, text in _a2l_texts(model, folder, texts, options or Options(), source or A2lSource()).items():
            write_whole(folder / path, text)
            content[path] = text
    return [folder / path for path in content]


def _a2l_texts(
    model: Model, folder: Path, texts: Mapping[str, str], options: Options, source: A2lSource
) -> dict[str, str]:
    """The A2L file and the README of its folder, with the addresses of the ELF."""
    elf = source.elf
    if elf is None:
        _make(folder, f"{model.name}.elf")
        elf = folder / f"{model.name}.elf"
    params = texts[f"model/{model.name}_params.h"]
    instance = source.instance or f"{model.name}_instance"
    learner = source.learner or f"{model.name}_learner" if model.learner else None
    if model.learner and source.elf is not None and not source.learner:
        learner = learner if learner in read_elf(elf).symbols else None
    described: Description = describe(
        model, interface(model, inverse=options.inverse), tables(model), read_elf(elf), instance, learner
    )
    facts = {
        **component_facts(model, options),
        "target": "a2l",
        "title": TARGETS["a2l"],
        "description": described,
        "digest": numbers_digest_of(params),
        "elf": elf.name,
    }
    return {f"{model.name}.a2l": render("export/a2l.j2", facts), "README.md": render("export/README.md.j2", facts)}


def _make(folder: Path, goal: str) -> None:
    """Build `goal` by the Makefile of the folder. Raises BuildError with the first error message."""
    command = ["make", "-C", str(folder), goal, f"CC={default_toolchain().command}"]
    try:
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError as fault:
        raise BuildError("make is not installed; install it, or build the folder by other means") from fault
    if run.returncode != 0:
        raise BuildError(f"{folder}: make {goal}: {(run.stderr.strip().splitlines() or ['no message'])[0]}")
