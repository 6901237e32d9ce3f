"""Measurement uncertainty after the GUM: sensor, budget of a simulated displacement, positions, history of a stage."""
