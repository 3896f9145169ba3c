"""Extra script of the stand-in library, run by SCons: lets Unity print the way that PlatformIO configures.

PlatformIO defines UNITY_INCLUDE_CONFIG_H for the tests only; the library itself has to see the same
configuration.
"""

from typing import Any

from SCons.Script import DefaultEnvironment, Import  # type: ignore[import-untyped]

main_env: Any = DefaultEnvironment()

if "test" in main_env["BUILD_TYPE"]:
    Import("env", "projenv")  # These become globals: the library's environment and that of the tests.
    library_env: Any = globals()["env"]
    tests_env: Any = globals()["projenv"]
    include = [tests_env.subst(str(folder)) for folder in tests_env["CPPPATH"]]
    library_env.Append(CPPDEFINES=["UNITY_INCLUDE_CONFIG_H"], CPPPATH=include)
