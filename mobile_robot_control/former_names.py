"""Former names of moved modules in docs/api: scripts that import them keep working."""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import Any

_PACKAGE = __name__.rpartition('.')[0]
MOVED = {f'{_PACKAGE}.{former}': f'{_PACKAGE}.{present}' for former, present in {
    'parameters.configuration': 'configuration.configure', 'parameters.files': 'configuration.files',
    'parameters.nodes': 'configuration.nodes', 'parameters.shared': 'configuration.shared',
    'registry': 'plugins.registry', 'tuning.scenarios': 'simulation.scenarios',
    'api.runs': 'runs.run', 'api.saving': 'runs.run_files', 'recording.bag_reader': 'runs.bag', 'reporting': 'pages',
    'reporting.animation': 'pages.animation', 'reporting.report_writing': 'pages.report_writing',
    'reporting.run_reading': 'runs.reading', 'reporting.sros2_policy': 'configuration.sros2_policy',
}.items()}
"""Present names by former ones."""


class FormerNames:
    """
    An importer of former names only; the module of a former name is the present module itself.

    It does without the base classes of `importlib.abc`: their import takes as long as the laws.
    """

    def find_spec(self, name: str, _path: Sequence[str] | None, _target: ModuleType | None = None) -> ModuleSpec | None:
        """Find a module by its former name."""
        return ModuleSpec(name, self) if name in MOVED else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the present module; keep its own specification, because the import replaces it."""
        module = import_module(MOVED[spec.name])
        spec.loader_state = module.__spec__
        return module

    def get_code(self, name: str) -> Any:
        """Return the code of a module that is run by its former name."""
        loader: Any = find_spec(MOVED[name]).loader  # type: ignore[union-attr]
        return loader.get_code(MOVED[name])

    def exec_module(self, module: ModuleType) -> None:
        """Give the module its own specification back."""
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """Let former names be imported."""
    if not any(isinstance(finder, FormerNames) for finder in sys.meta_path):
        # first: the modules of a renamed package also lie under their former names
        sys.meta_path.insert(0, FormerNames())
