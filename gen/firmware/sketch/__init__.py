"""What the templates of the sketch are told: pins, limits in the board's units, JSON paths."""
