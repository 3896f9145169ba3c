"""Builds and tests PlatformIO projects, unchanged, without PlatformIO's package registry."""
