"""Commands with more to them than a call; `gen.cli` registers them."""
