"""A made fleet: motors of one series whose truth is known, their sensors, wear, and effects that nobody declared."""
