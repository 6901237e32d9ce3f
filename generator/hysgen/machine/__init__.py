"""This computer: native builds, compiled kernels, whole-file writes, caches, threads, and where installed files lie."""
