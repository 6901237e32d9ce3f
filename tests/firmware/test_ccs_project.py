"""The project file for Code Composer Studio: complete, and every #include found by the rules of TI's compiler.

cl6x searches the folder of the including file, then each --include_path in order (SPRUI04F). Linked files stay
where they are, copied files lie in PROJECT_ROOT; FIRMWARE is a path variable relative to the project file.
"""

from __future__ import annotations

import fnmatch
import importlib.util
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).resolve().parents[2] / "firmware"
PROJECT = FIRMWARE / "ccs" / "hysgen_firmware.projectspec"
STANDARD = {"stdint.h", "stddef.h", "float.h", "limits.h", "c6x.h"}


def project() -> ElementTree.Element:
    found = ElementTree.parse(PROJECT).getroot().find("project")
    assert found is not None
    return found


def laid_out(root: Path) -> list[Path]:
    """The project's files as the compiler finds them; copied files are copied to `root`."""
    files = []
    for entry in project().iter("file"):
        path = (PROJECT.parent / entry.attrib["path"]).resolve()
        assert path.is_file(), path
        if entry.attrib["action"] == "copy":
            (root / path.name).write_bytes(path.read_bytes())
            path = root / path.name
        files.append(path)
    return files


def include_paths(root: Path) -> list[Path]:
    variables = {each.attrib["name"]: each.attrib["path"] for each in project().iter("pathVariable")}
    folders = re.findall(r'--include_path="([^"]+)"', project().attrib["compilerBuildOptions"])
    places = {"PROJECT_ROOT": root} | {name: (PROJECT.parent / path).resolve() for name, path in variables.items()}
    return [Path(re.sub(r"\$\{(\w+)\}", lambda found: str(places[found[1]]), folder)) for folder in folders]


def test_every_include_of_the_project_is_found_and_in_the_project(tmp_path: Path) -> None:
    files = laid_out(tmp_path)
    searched = include_paths(tmp_path)
    sources = [path for path in files if path.suffix in (".c", ".h")]
    assert len(sources) > 20
    for path in sources:
        for name in re.findall(r'^#include ["<]([^">]+)[">]', path.read_text(encoding="utf-8"), re.MULTILINE):
            if name in STANDARD:
                continue
            found = [folder / name for folder in (path.parent, *searched) if (folder / name).is_file()]
            assert found, f"{path.name}: {name} is in none of {[str(each) for each in searched]}"
            assert found[0] in files, f"{path.name}: {name} is found outside the project, in {found[0]}"


@pytest.mark.parametrize("folder", ["controller", "models/extended", "board/c6748"])
def test_no_source_of_the_firmware_is_missing(folder: str) -> None:
    listed = {entry.attrib["path"] for entry in project().iter("file")}
    assert {f"../{folder}/{path.name}" for path in (FIRMWARE / folder).glob("*.[ch]")} <= listed


def test_both_linkers_get_the_same_order_of_functions() -> None:
    """Every function of --preferred_order goes to a pattern of c6748.ld, the patterns rise, and every pattern has one.

    The suggestions act on functions in subsections of their own only.
    """
    board = FIRMWARE / "board" / "c6748"
    script, command = ((board / f"c6748.{suffix}").read_text(encoding="utf-8") for suffix in ("ld", "cmd"))
    statements = [each.split() for each in re.findall(r"\*\((\.text\.[^)]*)\)", script)]
    functions = re.findall(r"^--preferred_order=(\w+)$", command, re.MULTILINE)
    # The last statement takes what is left; `tick` is the assembler's, in place of TI's `interrupt` functions.
    assert statements[0] == [".text.tick"]
    ordered = statements[1:]
    places = [
        next(i for i, each in enumerate(ordered) if any(fnmatch.fnmatchcase(f".text.{name}", one) for one in each))
        for name in functions
    ]
    assert places == sorted(places)
    assert set(places) == set(range(len(ordered)))
    assert "--gen_func_subsections=on" in project().attrib["compilerBuildOptions"]


def test_the_target_configuration_connects_a_probe_to_this_device() -> None:
    """Each instance names the file that its reference ends in; the connection is the configuration's probe."""
    listed = [entry.attrib["path"] for entry in project().iter("file") if entry.attrib["path"].endswith(".ccxml")]
    assert len(listed) == 1
    configuration = ElementTree.parse(PROJECT.parent / listed[0]).getroot().find("configuration")
    assert configuration is not None
    for instance in configuration.iter("instance"):
        assert instance.attrib["href"] == f"{instance.attrib['xmlpath']}/{instance.attrib['xml']}"
    probe, connection = configuration.find("instance"), configuration.find("connection")
    assert probe is not None
    assert connection is not None
    assert probe.attrib["id"] == connection.attrib["id"]
    assert probe.attrib["xmlpath"] == "connections"
    devices = [each for each in connection.iter("instance") if each.attrib["xmlpath"] == "devices"]
    assert [each.attrib["desc"].removesuffix("_0") for each in devices] == [project().attrib["device"]]


def test_the_boot_image_step_runs_a_module_that_exists() -> None:
    step = re.fullmatch(
        r'python3 -m ([\w.]+) "\$\{BuildArtifactFileName\}" "[^"]+\.ais"', project().attrib["postBuildStep"]
    )
    assert step is not None
    assert importlib.util.find_spec(step[1]) is not None
