"""The float64 model: rules, path blocks, additive terms, its file, its simulation and its scores."""
