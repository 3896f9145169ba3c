"""What a refinement comes to: "explained", "partly explained", "nothing missing" or "unexplained"."""

from __future__ import annotations

from typing import Literal

Verdict = Literal["explained", "partly explained", "nothing missing", "unexplained"]
EXPLAINED = 1.3
"""Explained: the RMSE on left-out runs is at most this many noise floors."""
NOTHING = 1.5
"""Nothing missing: without any effect it is at most this many."""
