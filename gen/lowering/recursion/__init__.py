"""The recursion that a component becomes: increment form, reachable sets, bounds; for every arithmetic alike."""
