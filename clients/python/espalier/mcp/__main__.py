"""`python3 -m espalier.mcp`"""

import sys

from . import main

sys.exit(main())
