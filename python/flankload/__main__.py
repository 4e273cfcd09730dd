"""`python -m flankload` is the command `flankload`."""

import sys

from flankload.cli import main

sys.exit(main())
