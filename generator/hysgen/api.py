"""The Python interface for scripts and notebooks; `import hysgen` gives all of its names.

record = hysgen.load_record("record.csv")
study = hysgen.diagnose(record)             # errors of the simulation, their causes, an extended model
model = study.model                         # or hysgen.fit(record, memory=True)
code = hysgen.generate(model)               # the C, as text
hysgen.verify(code)                         # the C compared with its reference, bit for bit
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from hysgen.c674x.cost import Cost, cost_of_texts
from hysgen.certify.certificates import certify
from hysgen.checking.bits import VerifySettings, verify_texts
from hysgen.checking.bits.report import Report
from hysgen.codegen import Options, write
from hysgen.codegen import generate as generate_texts
from hysgen.codegen.manifest import read_folder
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study, diagnose_and_evaluate
from hysgen.display import Displayed, Summary
from hysgen.errors import HysgenError, RecordWarning
from hysgen.fitting import FitSettings, PathSize
from hysgen.fitting import fit as fit_model
from hysgen.model.file import load_model, save_model
from hysgen.model.model import Model
from hysgen.model.scores import Scores, score
from hysgen.record import Columns, Record, check_for_fit, check_validation, load_record
from hysgen.report.words import price_of

__all__ = [
    "Columns",
    "Cost",
    "DiagnoseSettings",
    "FitSettings",
    "Generated",
    "HysgenError",
    "Model",
    "Options",
    "Record",
    "RecordWarning",
    "Report",
    "Scores",
    "Study",
    "cost",
    "diagnose",
    "fit",
    "generate",
    "load_model",
    "load_record",
    "save_model",
    "score",
    "verify",
]

Progress = Callable[[float, str], None]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Generated(Displayed):
    """Generated files: the model, and texts by file name; `code["stage.h"]` is one text."""

    model: Model
    texts: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        return self.texts[name]

    def write(self, folder: str | Path) -> Path:
        """Write every file into a folder, each whole or not at all. Returns the folder."""
        write(self.texts, Path(folder))
        return Path(folder)

    def summary(self) -> Summary:
        """The files and their sizes."""
        rows = [[name, f"{len(text.splitlines())}", f"{len(text.encode())}"] for name, text in self.texts.items()]
        return Summary(f"C of model {self.model.name}: {len(self.texts)} files", ["file", "lines", "bytes"], rows)


def fit(
    record: Record,
    settings: FitSettings | None = None,
    *,
    memory: bool | PathSize = False,
    progress: Progress | None = None,
) -> Model:
    """A model of a record: by default the paper's structure with refined free run, otherwise as in `settings`.

    memory: whether the path before the rules holds a hysteresis, and its size if not the default `PathSize()`.
    Raises FitError or RecordError.
    """
    chosen = settings or FitSettings()
    if memory is not False:
        chosen = dataclasses.replace(chosen, memory=PathSize() if memory is True else memory)
    parameters = 3 * chosen.rules
    if chosen.memory is not None:
        parameters += chosen.memory.operator(*record.u_range_V).size
    _warn(check_for_fit(record, chosen.rules, parameters))
    return fit_model(record, chosen, progress=progress)


def _warn(lines: Iterable[str]) -> None:
    for line in lines:
        warnings.warn(line, RecordWarning, stacklevel=3)


def diagnose(
    record: Record,
    holdout: Record | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
) -> Study:
    """Errors of the simulation of a record, their causes, and the gain and price of an extended model.

    Structure and parameters come from `record` (from its first 65 % if `holdout` is None); scores are held out.
    Raises RecordError or FitError.
    """
    chosen = settings or DiagnoseSettings()
    if chosen.price is None:
        chosen = dataclasses.replace(chosen, price=price_of)
    _warn(check_for_fit(record, chosen.fit.rules, 3 * chosen.fit.rules))
    if holdout is not None:
        _warn(check_validation(record, holdout))
    return diagnose_and_evaluate(record, holdout, chosen, progress)


def generate(model: Model, options: Options | None = None) -> Generated:
    """The C of a model as text; by default with the inverse if that is certified.

    Raises CertificateError if the inverse in `options` is not certified, BudgetError if a sample exceeds its period.
    """
    chosen = options or Options(inverse=certify(model).inverse_holds)
    return Generated(model, generate_texts(model, chosen))


def verify(code: Generated | str | Path, samples: int = 200_000, progress: Progress | None = None) -> Report:
    """Compare generated C, or a folder of it, with its float32 reference, bit for bit, in every available build.

    samples: per build. Raises HysgenError if the folder is incomplete or there is no compiler.
    """
    settings = VerifySettings(samples=samples, other_models=0)
    if isinstance(code, Generated):
        return verify_texts(code.model, code.texts, settings, progress)
    folder = read_folder(Path(code))
    return verify_texts(folder.model, folder.texts, settings, progress, folder.altered)


def cost(code: Generated | str | Path) -> Cost:
    """The cost of generated C, or of a folder of it: operations, cycles against the sample period, bytes."""
    if isinstance(code, Generated):
        return cost_of_texts(code.model, code.texts, timed=False)
    folder = read_folder(Path(code))
    return cost_of_texts(folder.model, folder.texts, timed=False)
