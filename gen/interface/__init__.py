"""What `import gen` offers: one function for each step from measured runs to proven firmware.

The commands call these functions, too. Everything slow to import is imported by the function that needs it.
"""

from gen.interface.certificate import Check, check
from gen.interface.files import load, read_run
from gen.interface.firmware import Build, Verification, build, verify
from gen.interface.identification import Identification, NetworkIdentification, identify
from gen.interface.importing import Import, import_runs
from gen.interface.model import Model
from gen.interface.planning import Plan, plan
from gen.interface.refinement import Refinement, refine
from gen.interface.simulation import simulate

__all__ = [
    "Build",
    "Check",
    "Identification",
    "Import",
    "Model",
    "NetworkIdentification",
    "Plan",
    "Refinement",
    "Verification",
    "build",
    "check",
    "identify",
    "import_runs",
    "load",
    "plan",
    "read_run",
    "refine",
    "simulate",
    "verify",
]
