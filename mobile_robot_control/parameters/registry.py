"""
Named records that may come from outside the package: position laws and curves.

A record is built in, comes from an entry point of an installed package or from a Python file named by a command or an
environment variable, or is registered by hand. A value of a parameter never imports code.
"""

import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Generic, NamedTuple, TypeVar

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.system.files import PLUGIN, read_bounded
from mobile_robot_control.system.texts import describe_error, located_error, printable


def installed_entry_points(group: str) -> tuple[tuple[Any, ...], str]:
    """Return the entry points of a group, and the reason if they cannot be read; '' otherwise."""
    if not any(group in text for text in _entry_point_files()):
        return (), ''
    # this import takes a tenth of a node's start
    from importlib import metadata  # noqa: PLC0415

    try:
        return tuple(metadata.entry_points(group=group)), ''
    except Exception as error:  # Python reads those of all packages, and one may be broken
        return (), f'entry points of installed packages: {describe_error(error)}; mend the broken entry_points.txt'


def _entry_point_files() -> Iterator[str]:
    """Yield the texts of all files of entry points; for an archive, which is not opened, every group."""
    for folder in sys.path:
        try:
            names = [name for name in os.listdir(folder or '.') if name.endswith(('.dist-info', '.egg-info'))]
        except NotADirectoryError:
            yield 'mobile_robot_control.laws mobile_robot_control.velocity_laws mobile_robot_control.curves'
            continue
        except OSError:
            continue
        for name in names:
            try:
                with open(os.path.join(folder, name, 'entry_points.txt'), encoding='utf-8', errors='replace') as file:
                    yield file.read()
            except OSError:
                continue


def origin_of(function: object) -> str:
    """Return the file that defines a function; '__main__' for a notebook, whose cells have individual names."""
    code = getattr(function, '__code__', None)
    return '__main__' if code is None or function.__module__ == '__main__' else os.path.realpath(code.co_filename)


def source_checksum(function: object) -> str:
    """Return a checksum of a function's module, of all loaded modules of its package, or of a function at a prompt."""
    import hashlib  # noqa: PLC0415 (for searches alone: nodes start without it)

    digest = hashlib.sha256()
    for source in _sources(function):
        digest.update(source)
    return digest.hexdigest()[:16]


def _sources(function: Any) -> Iterator[bytes]:
    """Yield the texts of the files; without files, the code of the function."""
    package = function.__module__.partition('.')[0]
    ours = package in ('__main__', __name__.partition('.')[0])
    files = {os.path.realpath(function.__code__.co_filename)} if ours else {
        os.path.realpath(str(getattr(module, '__file__', ''))) for name, module in list(sys.modules.items())
        if name.partition('.')[0] == package}
    sources = [Path(file).read_bytes() for file in sorted(files) if file.endswith('.py') and os.path.exists(file)]
    yield from sources or [function.__code__.co_code]


Record = TypeVar('Record')
BUILT_IN = 'mobile_robot_control'
"""Origin of the records of this package."""


class PluginError(ParameterError):
    """A refused record; each violation has its origin, the reason and the remedy."""


class Source(NamedTuple):
    """
    The sources of a registry's records.

    Attributes
    ----------
    kind, attribute : str
        'law', 'velocity law' or 'curve', for messages; name of the record in its module.
    entry_points, variable : str
        Group of entry points; environment variable with file names, separated by `os.pathsep`.

    """

    kind: str
    attribute: str
    entry_points: str
    variable: str


class Registry(Mapping[str, Record], Generic[Record]):
    """
    The records by name, the built-in ones first.

    Parameters
    ----------
    source : Source
        The sources of further records; they are searched when the names are first needed.
    record : type
        Of the records.
    built_in : sequence of Record
        Each has a name.
    check, function_of : callable
        Yields the faults of a record, in words; returns the function of a record.

    Attributes
    ----------
    failures : dict of str to str
        Entry points and files that could not be registered, with the reason.

    """

    def __init__(
        self, source: Source, record: type[Record], built_in: tuple[Record, ...], check: Callable[[Any], Iterator[str]],
        function_of: Callable[[Record], object],
    ) -> None:
        self._source, self._check, self._function_of = source, check, function_of
        self.record = record
        self._records: dict[str, Record] = {}
        self._origins: dict[str, str] = {}
        self._loaded: dict[str, str] = {}
        self.failures: dict[str, str] = {}
        self._discovered, self._version = False, 0
        for one in built_in:
            self.register(one, BUILT_IN)
        REGISTRIES[source.kind] = self

    @property
    def kind(self) -> str:
        """What its records are, in words."""
        return self._source.kind

    @property
    def variable(self) -> str:
        """Name of the environment variable with file names."""
        return self._source.variable

    @property
    def option(self) -> str:
        """Option of commands that names files of its records."""
        return f'--{self.kind.replace(" ", "-")}'

    @property
    def remedy(self) -> str:
        """How to load a record that is missing."""
        kind = self._source.kind
        return f'name the file of a {kind} of your own with {self.option}, or register it in Python'

    @property
    def version(self) -> int:
        """A number that grows with each change."""
        self._discover()
        return self._version

    def remove(self, name: str) -> None:
        """Forget a record; a built-in one stays."""
        if self._origins.get(name) not in (None, BUILT_IN):
            self._loaded.pop(self._origins.pop(name), None)
            del self._records[name]
            self._version += 1

    def load_file(self, path: str | Path) -> tuple[Record, ...]:
        """Import a Python file and register its records; raise PluginError if that fails."""
        file = os.path.realpath(path)
        try:
            code = read_bounded(Path(file), PLUGIN).decode()
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
            raise PluginError([f'{path}: cannot be read ({reason}); name a Python file']) from error
        return self.load_text(file, code)

    def changed_files(self) -> dict[str, str]:
        """Return the new text of each loaded file that has changed on disk, by path."""
        changed = {}
        for file, loaded in self.loaded_texts().items():
            with contextlib.suppress(OSError, UnicodeDecodeError):
                present = read_bounded(Path(file), PLUGIN).decode()
                if present != loaded:
                    changed[file] = present
        return changed

    def load_changed(self) -> dict[str, str]:
        """
        Load again the files that have changed on disk.

        Returns
        -------
        dict of str to str
            The checksum of the text of each reloaded record, by its name.

        Raises
        ------
        PluginError
            If a file is refused; its record stays unchanged.

        """
        import hashlib  # noqa: PLC0415 (nodes start without it)

        return {record.name: hashlib.sha256(text.encode()).hexdigest()[:16]  # type: ignore[attr-defined]
                for file, text in self.changed_files().items() for record in self.load_text(file, text)}

    def load_text(self, file: str, code: str) -> tuple[Record, ...]:
        """
        Import the text of a Python file, which may be missing here; see `load_file`.

        Its records are LAW or CURVE, and those that it registers itself; a refused file leaves the registry unchanged.
        """
        before = dict(self._records), dict(self._origins)
        module = ModuleType(f'mobile_robot_control_plugin_{re.sub(r"[^0-9a-zA-Z]", "_", file)}')
        module.__file__, sys.modules[module.__name__] = file, module
        try:
            # output during the import must not mix with the results of a command
            with contextlib.redirect_stdout(sys.stderr):
                exec(compile(code, file, 'exec', dont_inherit=True), module.__dict__)  # noqa: S102 (the user's own)
            named = getattr(module, self._source.attribute, None)
            if named is not None and not any(named is record for record in self._records.values()):
                self.register(named, file)
            records = tuple(record for name, record in self._records.items()
                            if self._origins[name] == file and record is not before[0].get(name))
            if not records:
                raise PluginError([self._lacking()])
        except BaseException as error:
            sys.modules.pop(module.__name__, None)
            self._records, self._origins = before
            raise PluginError([self._refusal(file, error)]) from error
        self._loaded[file] = code
        return records

    def _lacking(self) -> str:
        """Return the words for a file without a record."""
        attribute, record = self._source.attribute, self.record
        fields = [name for name in record._fields if name not in record._field_defaults]  # type: ignore[attr-defined]
        return f"has no {attribute}; end it with {attribute} = {record.__name__}({', '.join(fields)})"

    def _refusal(self, where: str, error: BaseException) -> str:
        if isinstance(error, PluginError):
            return '; '.join(text if text.startswith(where) else f'{where}: {text}' for text in error.violations)
        return f'{where}: cannot be imported ({located_error(error)}); mend it, or leave it out'

    def register(self, record: Record, origin: str = '') -> None:
        """Register a record, or replace that of the same name and origin; '' stands for its file or notebook."""
        violations = list(self._check(record))
        if violations:
            raise PluginError(f'{origin}: {violation}' if origin else violation for violation in violations)
        origin = origin or origin_of(self._function_of(record))
        name: str = record.name  # type: ignore[attr-defined]
        if self._origins.get(name, origin) != origin:
            raise PluginError([f"{origin}: the {self._source.kind} '{name}' is defined in {self._origins[name]} "
                               'already; rename one of them'])
        self._records[name], self._origins[name] = record, origin
        self._version += 1

    def _discover(self) -> None:
        """Load the records of the environment and of installed packages; failures stop nothing."""
        if self._discovered:
            return
        self._discovered = True
        for file in filter(None, os.environ.get(self._source.variable, '').split(os.pathsep)):
            if os.path.realpath(file) not in self._loaded:
                try:
                    self.load_file(file)
                except PluginError as error:
                    self.note_failure(file, str(error))
        points, fault = installed_entry_points(self._source.entry_points)
        if fault:
            self.note_failure('entry points', fault)
        for point in points:
            try:
                with contextlib.redirect_stdout(sys.stderr):
                    record = point.load()
                self.register(record)
            except BaseException as error:  # a module may raise anything, SystemExit too
                self.note_failure(point.name, self._refusal(f'entry point {point.name} = {point.value}', error))

    def note_failure(self, name: str, reason: str) -> None:
        """Keep the reason why a file or an entry point was not loaded, and print it."""
        self.failures[name] = reason
        print(f'not loaded: {printable(reason)}', file=sys.stderr)

    def origin(self, name: str) -> str:
        """Return the origin of a record: a file, '__main__' or 'mobile_robot_control'."""
        self._discover()
        return self._origins[name]

    def checksum(self, name: str) -> str:
        """Return a checksum of a record's source: a file, or all loaded modules of its package."""
        return source_checksum(self._function_of(self[name]))

    def loaded_texts(self) -> dict[str, str]:
        """Return the text of each file with a loaded record, by path, so that other processes can load it."""
        self._discover()
        return dict(self._loaded)

    def __getitem__(self, name: str) -> Record:
        self._discover()
        return self._records[name]

    def __iter__(self) -> Iterator[str]:
        self._discover()
        return iter(self._records)

    def __len__(self) -> int:
        self._discover()
        return len(self._records)


REGISTRIES: dict[str, Registry[Any]] = {}
"""The registries by their kind, 'law', 'velocity law' and 'curve'; each enters itself."""


def name_violations(kind: str, name: object, reserved: frozenset[str] = frozenset()) -> Iterator[str]:
    """Yield the faults in the name of a record."""
    if not isinstance(name, str) or not re.fullmatch('[a-z][a-z0-9_]*', name):
        yield f'the name {name!r} of a {kind} is no ROS name; write lower-case letters, digits and underscores'
    elif name in reserved:
        yield f"the {kind} '{name}' has the name of a parameter; take another name"
