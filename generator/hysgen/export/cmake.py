"""CMake: a package for `find_package`, and a project that uses it."""

from __future__ import annotations

from pathlib import Path

from hysgen.export.base import Export, Samples, Words, output_of, results
from hysgen.model.model import Model

README = """\
    cmake -S . -B build -DCMAKE_INSTALL_PREFIX=$PWD/install && cmake --build build
    ctest --test-dir build && cmake --install build
    cmake -S consumer -B consumer/build -DCMAKE_PREFIX_PATH=$PWD/install && cmake --build consumer/build
    consumer/build/consumer

Your project: `find_package({{ name }} REQUIRED)`, `target_link_libraries(yours PRIVATE {{ name }}::{{ name }})`.
"""


def run_cmake(model: Model, folder: Path, samples: Samples) -> Words:
    """The program run.c of the package."""
    output_of(["cmake", "-S", ".", "-B", "build"], folder)
    output_of(["cmake", "--build", "build", "--target", f"{model.name}_run"], folder)
    program = (folder / "build" / f"{model.name}_run").resolve()
    return results(output_of([str(program), *samples.start], folder, samples.rows.tobytes()))


EXPORT = Export(
    "cmake",
    "CMake package",
    files={
        "CMakeLists.txt": "cmake_CMakeLists.txt",
        "consumer/CMakeLists.txt": "cmake_consumer.txt",
        "run.c": "run.c",
    },
    readme=README,
    ways={"CMake": run_cmake},
)
