"""The float64 model: rules, input blocks, additive terms, model file, simulation and scores."""
