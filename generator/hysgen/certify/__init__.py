"""What is guaranteed of a model: contraction, gain, slopes, enclosures of its range."""
