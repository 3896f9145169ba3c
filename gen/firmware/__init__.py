"""From the lowered program to the emitted PlatformIO project."""
