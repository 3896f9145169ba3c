"""Commands that have a module of their own; `gen.cli` registers them."""
