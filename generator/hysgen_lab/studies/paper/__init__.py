"""The paper's experiments repeated on the virtual stage: modelling, tracking, and the learner in generated C."""
