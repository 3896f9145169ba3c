"""A network while it is changed: its numbers with their derivatives, its file's entries, columns that it hears of."""
