"""A feedback loop around the inverse of a model: designed, certified over the uncertainty of the model, and emitted."""
