"""Build script of the stand-in platform: becomes `builder/main.py`, run by SCons."""

from typing import Any

from SCons.Script import Default, DefaultEnvironment  # type: ignore[import-untyped]

env: Any = DefaultEnvironment()
env.Replace(CC="gcc", CXX="g++")
Default(env.BuildProgram())
