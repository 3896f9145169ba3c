"""How the board takes a half, a third, a fourth and a fifth in fixed point."""

from __future__ import annotations

from typing import Final

EXTRA_SHIFT: Final = {2: 1, 3: 0, 4: 2, 5: 0}
"""By the series' term k: a half and a fourth are shifts of the sum, a third and a fifth are of the term before."""
WEIGHT: Final = {3: 85, 5: 51}
"""A third as 85/256 (1 + 1/256), a fifth as 51/256 (1 + 1/256): off by 2^-16 of themselves."""
