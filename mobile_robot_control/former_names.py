"""Modules that were moved, by the names under which docs/api had them: scripts that import these go on."""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

_PACKAGE = __name__.rpartition('.')[0]
MOVED = {f'{_PACKAGE}.{former}': f'{_PACKAGE}.{present}' for former, present in {
    'parameters.configuration': 'configuration.configure', 'parameters.files': 'configuration.files',
    'parameters.nodes': 'configuration.nodes', 'parameters.shared': 'configuration.shared',
    'registry': 'plugins.registry', 'tuning.scenarios': 'simulation.scenarios',
}.items()}
"""Present names by former ones."""


class FormerNames(Loader, MetaPathFinder):
    """An importer that comes after all others; the module of a former name is the present one itself."""

    def find_spec(self, name: str, _path: Sequence[str] | None, _target: ModuleType | None = None) -> ModuleSpec | None:
        """Find a module by its former name."""
        return ModuleSpec(name, self) if name in MOVED else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the present module; keep its own specification, which the import replaces."""
        module = import_module(MOVED[spec.name])
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Give the module its own specification back."""
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """Let former names be imported."""
    if not any(isinstance(finder, FormerNames) for finder in sys.meta_path):
        sys.meta_path.append(FormerNames())
