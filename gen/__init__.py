"""From identified motor-temperature coefficients to proven firmware for the Arduino Mega 2560."""

__version__ = "0.1.0"
