"""Which columns are the time, how it is written, and in what unit."""
