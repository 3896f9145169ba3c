"""`python -m gen`, and the `gen` command.

Nothing slow is imported here: until `main` begins an interrupt ends in Python's own traceback.
"""

import os
import signal
import sys


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded ends it as quietly as a later one."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    from gen.cli import main as run

    run()


def _end(*_: object) -> None:
    """End at once: there is nothing to clear away yet, and not every import passes an exception on as it is."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except Exception:  # a stream that is closed, or in use: the end is what was asked for
            continue
    os.write(2, b"interrupted\n")
    os._exit(128 + signal.SIGINT)


if __name__ == "__main__":
    main()
