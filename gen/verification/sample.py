"""The emitted `NAME_Sample` as the harnesses read it."""

from __future__ import annotations

Field = tuple[str, str] | tuple[str, str, tuple[int, ...]]


def sample_fields(components: int) -> list[Field]:
    """What was measured at a sample, byte by byte, packed and little endian.

    Parameters
    ----------
    components
        How many parts there are.
    """
    return [
        ("measured_mC", "<i4", (components,)),
        ("ambient_mC", "<i4"),
        ("valid", "<u2"),
        ("plausible", "<u2"),
        ("rising_mK", "<u2", (components,)),
    ]
