"""What workers compute for a fleet, motor by motor, and how it is spread over them."""
