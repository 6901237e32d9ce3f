"""The Python interface for scripts and notebooks; `import hysgen` gives all of its names, and so do the verbs.

record = hysgen.load_record("record.csv")
study = hysgen.diagnose(record)             # errors of the simulation, their causes, an extended model
model = study.model                         # or hysgen.fit(record, memory=True)
code = hysgen.generate(model)               # the C, as text
hysgen.verify(code)                         # the C compared with its reference, bit for bit

models: from records to models and causes, models compared, reports. code: C, its checks, firmware.
"""
