"""Examples of coefficient files, with the scripts that made or judge them."""
