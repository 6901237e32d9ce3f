"""The generated C as a graph of operations on 32-bit words: reader, symbolic execution, dataflow."""
