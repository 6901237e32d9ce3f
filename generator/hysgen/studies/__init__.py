"""Studies over many records: the bank of hidden effects and the experiments of the paper."""
