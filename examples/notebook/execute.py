"""Run a notebook and store its outputs in it: ``python examples/notebook/execute.py NOTEBOOK``.

Needs the package with its ``test`` extra. The kernel works in the notebook's own folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

LONGEST_S = 1200
"""For one cell; what takes longer hangs."""


def execute(path: Path) -> None:
    """Run all cells in a new kernel; outputs, and nothing that names the machine, are stored.

    Raises
    ------
    CellExecutionError
        If a cell fails; the file is as before then.
    """
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook, timeout=LONGEST_S, resources={"metadata": {"path": str(path.parent)}}, record_timing=False
    )
    client.execute()
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    nbformat.write(notebook, path)


if __name__ == "__main__":
    execute(Path(sys.argv[1]))
