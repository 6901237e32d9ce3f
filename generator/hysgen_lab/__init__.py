"""The laboratory: virtual stages, banks of hidden effects, the paper's experiments, endurance, tracking."""
