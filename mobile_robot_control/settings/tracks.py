"""The tracks of a benchmark: files that say which robot drives what, from where, and why."""

import os
from collections.abc import Mapping
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.model.motors import LONGEST_DELAY
from mobile_robot_control.parameters.declaration import Field, ParameterError, nearest
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.reference.curves import CURVES, OF_FILES
from mobile_robot_control.reference.waypoint_files import WAYPOINTS
from mobile_robot_control.settings.configure import ParameterSources, shipped_folder
from mobile_robot_control.settings.files import FILES, TRACK, read_parameter_file
from mobile_robot_control.system.files import read_bounded
from mobile_robot_control.system.texts import shortened

_PUBLISHED = 'published'


class TrackParameters(NamedTuple):
    """The section `track` of a track's file: what is drawn; robot, rates and limits stand in the sections of nodes."""

    purpose: Annotated[str, Field('', 'why the track exists, in a sentence')]
    robot: Annotated[str | None, Field('', 'robot of this package, or its file; the default one, if left out')] = None
    curves: Annotated[tuple[str, ...], Field('', 'curves to draw from; the path or trajectory of the file, if that '
                                             'names one', choices=CURVES)] = ('trifolium', 'lemniscate')
    scales: Annotated[tuple[float, ...], Field('m', 'sizes of the curves to draw from', above=0.0)] = (0.5, 1.0)
    laps: Annotated[float, Field('', 'length of a run', above=0.0)] = 1.0
    within: Annotated[float, Field('m', "largest distance of the robot's start from the cart's", minimum=0.0)] = 0.01
    turned: Annotated[float, Field('rad', 'largest difference of their headings', minimum=0.0, maximum=3.15)] = 0.02
    variation: Annotated[float, Field('', "largest relative change of the robot's mass and of its friction",
                                      minimum=0.0, below=1.0)] = 0.0
    delays: Annotated[tuple[int, ...], Field('', 'least and largest delay of the torques, in periods of the velocity '
                                             'loop', minimum=0, maximum=LONGEST_DELAY, length=2)] = ()
    group: Annotated[str, Field('', 'tracks of one group count once in a mean over tracks; by default its own name')
                     ] = ''
    objective: Annotated[str, Field('', 'what searches minimise on it: Eq. (29) of the chapter, or the RMS position '
                                    'error, which ranks', choices=('rms_position_error', 'eq29'))] = (
        'rms_position_error')
    success_within: Annotated[float, Field('m', 'a run succeeds that stays nearer to the reference over its last '
                                           'quarter', above=0.0)] = 0.1


class Published(NamedTuple):
    """
    What a publication reports of a law on a track.

    Attributes
    ----------
    law : str
        Its name here.
    gains : dict of str to object
        Of the publication, by their names here.
    metrics : dict of str to float
        That it reports, by their names in docs/metrics.md [SI].
    initial_pose : sequence of float or None
        Where the robot starts [m, m, rad]; None for the cart's start.
    """

    law: str
    gains: dict[str, Any]
    metrics: dict[str, float]
    initial_pose: Any


class Track(NamedTuple):
    """
    A track that has been read.

    Attributes
    ----------
    name : str
        Of its file, without the ending.
    file : Path
        That every node loads, too.
    parameters : TrackParameters
        What is drawn.
    source : str
        The publication it is taken from; '' where it is of none.
    published : tuple of Published
        What that reports.
    """

    name: str
    file: Path
    parameters: TrackParameters
    source: str = ''
    published: tuple[Published, ...] = ()

    def sources(self, more: ParameterSources) -> ParameterSources:
        """Return where the parameters of its loop come from, on top of which further ones win."""
        return more._replace(robot=self.parameters.robot, files=(str(self.file), *more.files))

    def content(self, more: ParameterSources) -> dict[str, Any]:
        """Return all that the track is made of, without names of files: for JSON."""
        values = self.sources(more).values()
        for given in values.values():
            for name in {*FILES} & {*given}:
                given[name] = sha256(read_bounded(Path(given[name]), WAYPOINTS)).hexdigest()[:16]
        drawn = self.parameters._asdict()
        return {**{name: value for name, value in drawn.items()
                   if name not in ('purpose', 'group', 'objective')}, 'values': values}


@lru_cache(maxsize=1)
def shipped_tracks() -> dict[str, Path]:
    """Return the files of this package's tracks by name, in the order of their reading."""
    folder = shipped_folder('tracks')
    return {file.stem: file for file in sorted(folder.glob('*.yaml'))} if folder else {}


def read_track(track: str) -> Track:
    """
    Read a track, by its name or by the path of its file.

    Raises
    ------
    ParameterError
        If there is none of that name, or its file says what a track cannot have.
    """
    shipped = shipped_tracks()
    if track not in shipped and not (os.path.lexists(track) or '/' in track or track.endswith(('.yaml', '.yml'))):
        raise ParameterError([f"--tracks '{track}': there is no track of this name; {nearest(track, shipped)}; a file "
                              'of your own is named by its path, such as ./my_track.yaml'])
    file = shipped.get(track, Path(track))
    sections = {name.strip('/'): values for name, values in read_parameter_file(file)}
    if TRACK not in sections:
        raise ParameterError([f"{file}: has no section '{TRACK}'; write 'track: {{ros__parameters: {{purpose: "
                              "...}}}}'"])
    try:
        parameters = make_request(TrackParameters, sections[TRACK])
    except ParameterError as error:
        raise ParameterError(f'{file}: {TRACK}: {violation}' for violation in error.violations) from None
    for name in ('curves', 'scales'):
        if not getattr(parameters, name):
            raise ParameterError([f'{file}: {TRACK}: {name} = [] draws from nothing; name one or more'])
    for course in {*OF_FILES} & {values.get('curve') for values in sections.values()}:
        parameters = parameters._replace(curves=(course,), scales=parameters.scales[:1])
    source, published = _published(file, sections.get(_PUBLISHED, {}))
    return Track(file.stem, file, parameters, source, published)


def _published(file: Path, values: Mapping[str, Any]) -> tuple[str, tuple[Published, ...]]:
    """Return the publication, and what it reports, of the section of that name; gains and poses as they are."""
    by_law: dict[str, Published] = {}
    violations = []
    for name, value in values.items():
        law, _, rest = name.partition('.')
        if not rest:
            continue
        entry = by_law.setdefault(law, Published(law, {}, {}, None))
        group, _, field = rest.partition('.')
        if rest == 'initial_pose':
            by_law[law] = entry._replace(initial_pose=value)
        elif group == 'gains' and field:
            entry.gains[field] = value
        elif group == 'metrics' and field and type(value) in (int, float) and abs(value) <= LARGEST:
            entry.metrics[field] = float(value)
        else:
            violations.append(f'{file}: {_PUBLISHED}: {shortened(f"{name} = {value!r}")} is not allowed; a law has '
                              'gains, initial_pose, and metrics with one number each')
    if violations:
        raise ParameterError(violations)
    return str(values.get('source', '')), tuple(by_law.values())
