"""`python -m symdyn` is the command line."""

import sys

from symdyn.cli import main

if __name__ == "__main__":
    sys.exit(main())
