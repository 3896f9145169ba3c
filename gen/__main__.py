"""`python -m gen`, and the `gen` command."""

import sys


def main() -> None:
    """Run the command line; an interrupt while it is still being loaded ends it as quietly as a later one."""
    try:
        from gen.cli import main as run
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
