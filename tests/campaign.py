"""Whether campaigns are to be run in full: with GEN_CAMPAIGN=full."""

from __future__ import annotations

import os

FULL = os.environ.get("GEN_CAMPAIGN") == "full"
