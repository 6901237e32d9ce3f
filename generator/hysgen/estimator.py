"""A small estimator in the manner of scikit-learn, for cross-validation and pipelines; scikit-learn is not needed.

    X    (n,) or (n, 1) voltage in V         y    (n,) displacement in um

`fit` identifies a model, `predict` is its free run from rest, `score` the coefficient of determination R^2 of the free
run. Rows are samples in time: split them in blocks (TimeSeriesSplit), never shuffled.
"""

import importlib
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import FitError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.model import Model
from hysgen.model.scores import unknown_past
from hysgen.model.simulate import series
from hysgen.record import Record
from hysgen.record.noise import noise_floor

Floats = NDArray[np.float64]


class HysteresisRegressor:
    """A hysteresis model as an estimator.

    Ts_s: sampling period in s, which `fit` needs. rules: fuzzy rules. memory: a hysteresis before the rules. method: as
    FitSettings. model_: the fitted model, after `fit`. Raises FitError and RecordError as `fit` of a record does.
    """

    _estimator_type = "regressor"
    """How scikit-learn before 1.6 knows a regressor."""

    def __init__(self, Ts_s: float | None = None, rules: int = 6, memory: bool = True, method: str = "refined") -> None:
        self.Ts_s = Ts_s
        self.rules = rules
        self.memory = memory
        self.method = method

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name."""
        return {name: getattr(self, name) for name in ("Ts_s", "rules", "memory", "method")}

    def set_params(self, **parameters: Any) -> Self:
        """Change parameters. Raises FitError for an unknown name."""
        for name, value in parameters.items():
            if name not in self.get_params():
                raise FitError(f"{name}: is no parameter; choose from {', '.join(self.get_params())}")
            setattr(self, name, value)
        return self

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Identify a model of the displacement y under the voltage X."""
        memory = PathSize() if self.memory else None
        settings = FitSettings(rules=self.rules, memory=memory, method=self.method)  # type: ignore[arg-type]
        self.model_: Model = fit(self._record(X, y), settings)
        return self

    def predict(self, X: ArrayLike) -> Floats:
        """Free run in um, (n,), from rest under the first voltage. Raises FitError before `fit`."""
        return self._fitted().simulate(X)

    def score(self, X: ArrayLike, y: ArrayLike) -> float:
        """R^2 = 1 - sum (y - yhat)^2 / sum (y - mean y)^2, without the samples that depend on the unknown past."""
        model, record = self._fitted(), self._record(X, y)
        first = unknown_past(model, record, noise_floor(record).rms_um).rows[0]
        measured = record.y_um
        error = (measured - model.simulate(record.u_V, float(measured[0])))[first:]
        about = measured[first:] - measured[first:].mean()
        return 1.0 - float(error @ error) / max(float(about @ about), 1e-300)

    def __sklearn_tags__(self) -> Any:
        """What scikit-learn from 1.6 on asks of a regressor, in its own types; only scikit-learn calls this."""
        kinds = importlib.import_module("sklearn.utils")
        return kinds.Tags(
            estimator_type="regressor",
            target_tags=kinds.TargetTags(required=True),
            regressor_tags=kinds.RegressorTags(),
            input_tags=kinds.InputTags(),
        )

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "model_")

    def _record(self, X: ArrayLike, y: ArrayLike) -> Record:
        if self.Ts_s is None:
            raise FitError("Ts_s: is missing; give the sampling period in s, as HysteresisRegressor(Ts_s=2e-5)")
        return Record.from_arrays(series(X, "X"), series(y, "y"), self.Ts_s)

    def _fitted(self) -> Model:
        if not hasattr(self, "model_"):
            raise FitError("the estimator is not fitted; call fit(X, y) first")
        return self.model_

    def __repr__(self) -> str:
        return f"HysteresisRegressor({', '.join(f'{name}={value!r}' for name, value in self.get_params().items())})"
