"""`python -m hysgen` is the command `hysgen`."""

from hysgen.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
