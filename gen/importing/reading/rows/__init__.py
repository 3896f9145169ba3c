"""Rows of cells to a table: what stands above, beside and below them."""
