"""`python -m lgmd2jax.cli`, the same as the command."""

import sys

from lgmd2jax.cli.main import main

sys.exit(main())
