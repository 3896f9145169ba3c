"""Heat, or cooling, over time: what is missing that no effect is, and what it is like."""
