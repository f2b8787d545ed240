"""
Execute the notebook of this folder, and write it with its outputs.

By hand: ``python examples/tutorial/execute.py``; ``make pages`` does it, too. It is executed by this interpreter, in a
folder that is removed afterwards, and without the settings of the user.
"""

import os
import sys
import tempfile
from pathlib import Path

import nbformat
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

NOTEBOOK = Path(__file__).with_name('trajectory_tracking.ipynb')
LONGEST = 300
"""[s]: the most that a cell may take."""
WITHOUT = ('MPLBACKEND', 'MOBILE_ROBOT_CONTROL_LAWS', 'MOBILE_ROBOT_CONTROL_CURVES')
"""Variables of the environment that would change what the notebook shows."""


def executed(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """
    Return a notebook with the outputs of this interpreter; the one given stays as it is.

    Raises
    ------
    CellExecutionError
        If a cell raises.

    """
    made = nbformat.from_dict(notebook)
    with tempfile.TemporaryDirectory() as folder:
        environment = {name: value for name, value in os.environ.items() if name not in WITHOUT}
        # without folders of kernels, the kernel is this interpreter
        manager = AsyncKernelManager(kernel_spec_manager=KernelSpecManager(kernel_dirs=[]),
                                     connection_file=f'{folder}/kernel.json')
        client = NotebookClient(made, km=manager, timeout=LONGEST, record_timing=False,
                                resources={'metadata': {'path': folder}})
        client.execute(cleanup_kc=True, env={**environment, 'IPYTHONDIR': f'{folder}/ipython', 'TMPDIR': folder})
    # the version of Python is one of this machine
    made.metadata = notebook.metadata
    return made


def main(file: Path = NOTEBOOK) -> int:
    """Execute a notebook in its place; return an exit code."""
    try:
        made = executed(nbformat.read(file, as_version=4))
    except CellExecutionError as error:
        print(f'execute: {file.name}: {error}', file=sys.stderr)
        return 1
    nbformat.write(made, file)
    return 0


if __name__ == '__main__':
    sys.exit(main())
