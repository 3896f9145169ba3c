"""What a table's columns are: time, input, temperatures, the room; and why."""
