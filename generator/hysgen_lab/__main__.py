"""`python -m hysgen_lab VERB ...`: the studies on the virtual stage."""

import sys

from hysgen.cli import main
from hysgen_lab.verbs import LABORATORY

if __name__ == "__main__":
    sys.exit(main(program=LABORATORY))
