"""The source study of the MY1016: reproduced from its numbers, and compared with `gen identify` on the same data."""
