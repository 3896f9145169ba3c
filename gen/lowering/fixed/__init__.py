"""Components in fixed point."""

from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.lower import TARGET_K, lower_component, with_rows

__all__ = ["TARGET_K", "FixedComponent", "lower_component", "with_rows"]
