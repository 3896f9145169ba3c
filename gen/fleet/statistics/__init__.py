"""What motors of one type have in common, and which one differs: numbers alone."""
