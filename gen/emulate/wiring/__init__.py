"""What is at the emulated Mega's pins, cycle by cycle: sensors, LEDs, pulses, supply, EEPROM."""
