"""`python -m linecontact`, for `linecontact` where that is not on the path."""

import sys

from .studies.__main__ import main

sys.exit(main())
