"""Studies over many records: the bank of hidden effects, the experiments of the paper, endurance of the learner."""
