"""The shipped set of a law: the gains of `config/LAW.yaml` that it reads, and the velocity gains of that file."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.control.laws import LAWS, groups_of
from mobile_robot_control.parameters.declaration import ParameterError, declarations, flatten, nearest
from mobile_robot_control.settings.configure import ParameterSources, configure, shipped_folder
from mobile_robot_control.settings.files import Values, load, read_override
from mobile_robot_control.settings.nodes import NODES, Configuration
from mobile_robot_control.system.texts import printable

POSITION, VELOCITY = 'position_controller', 'velocity_controller'
LAW = 'controller_type'
_CONDITIONS = ('velocity_rate', 'position_rate', 'lockstep')
Present = Mapping[str, Mapping[str, Any]]


class LawSet(NamedTuple):
    """
    The shipped set of a law.

    Attributes
    ----------
    law : str
        Its name.
    file : Path
        With the set.
    values : dict of str to dict
        By node: the law's name, the groups of gains that it reads, and the velocity gains.
    conditions : dict of str to object
        Robot and rates for which the gains were found, by parameter.

    """

    law: str
    file: Path
    values: Values
    conditions: dict[str, Any]

    @property
    def given(self) -> str:
        """The file as a command takes it from the repository's top folder."""
        return f'config/{self.file.name}'


@lru_cache(maxsize=32)
def shipped_set(law: str) -> LawSet | None:
    """Return the shipped set of a law; None for a law from elsewhere, or a package without its parameter files."""
    folder = shipped_folder('')
    file = folder / f'{law}.yaml' if folder else None
    if file is None or law not in LAWS or not file.is_file():
        return None
    nodes = {node: _listed(part) for node, part in configure(load([file]))._asdict().items()}
    groups = groups_of(LAWS[law])
    of_law = {name: value for name, value in nodes[POSITION].items() if name == LAW or name.partition('.')[0] in groups}
    gains = {name: value for name, value in nodes[VELOCITY].items() if name.startswith('gains.')}
    return LawSet(law, file, {VELOCITY: gains, POSITION: of_law}, {
        name: value for name, value in nodes[POSITION].items() if name in _CONDITIONS or name.startswith('robot.')})


def _listed(part: object) -> dict[str, Any]:
    """Return a node's parameters by dotted name, arrays as lists."""
    return {name: list(value) if isinstance(value, tuple) else value for name, value in flatten(part).items()}


def shipped(law: str) -> dict[str, Any]:
    """
    Return the shipped set of a law as parameters by ``NODE.PARAMETER``, with the horizon that it needs, if any.

    Raises
    ------
    ParameterError
        If the package has no set for it.

    Examples
    --------
    >>> shipped('kanayama')['position_controller.kanayama.kx']
    2.2111

    """
    law_set = shipped_set(law)
    if law_set is None:
        names = [name for name in LAWS if shipped_set(name)]
        raise ParameterError([f"law = '{printable(law)}' has no shipped set; {nearest(law, names)}"])
    horizon = {'/**.reference_horizon': LAWS[law].horizon} if LAWS[law].horizon else {}
    return horizon | {
        f'{node}.{name}': value for node, values in law_set.values.items() for name, value in values.items()}


def gains_of(configuration: Configuration) -> str:
    """Return 'shipped' or 'changed' for the gains of a configuration's law; '' for one without a set for its robot."""
    present = {node: _listed(part) for node, part in configuration._asdict().items()}
    found = set_for(configuration.position_controller.control.controller_type, present)
    return '' if found is None else 'changed' if differing(found, present) else 'shipped'


def set_for(law: str, present: Present) -> LawSet | None:
    """Return the shipped set of a law if its robot and rates are those of the nodes with these parameters."""
    law_set = shipped_set(law)
    takes_torque = VELOCITY in present and present.get('plant', {}).get('drive') != 'velocity'
    return law_set if law_set and takes_torque and _fits(law_set, present.get(POSITION, {})) else None


def _fits(law_set: LawSet, own: Mapping[str, object]) -> bool:
    """Return whether a set is for the robot and rates of a position controller with these parameters."""
    return all(own.get(name) == value for name, value in law_set.conditions.items())


def differing(law_set: LawSet, present: Present) -> Values:
    """Return the values of a set that differ from the present ones, by node, of nodes that are present."""
    unlike = {node: {name: value for name, value in values.items() if present[node].get(name) != value}
              for node, values in law_set.values.items() if node in present}
    return {node: values for node, values in unlike.items() if values}


def _group(node: str, name: str) -> tuple[str, str]:
    return node, name.partition('.')[0]


def groups_set_by_user(present: Present) -> set[tuple[str, str]]:
    """Return the groups, as node and group, whose present gains are neither the defaults nor those of a shipped set."""
    sets = [found.values for law in LAWS if (found := shipped_set(law))]
    defaults = {node: {name: list(one.default) if isinstance(one.default, tuple) else one.default
                       for name, one in declarations(NODES[node]).items()} for node in (POSITION, VELOCITY)}
    users: set[tuple[str, str]] = set()
    for node, group in {_group(node, name) for values in sets for node, given in values.items() for name in given}:
        known_gains = [{name: value for name, value in values[node].items() if _group(node, name) == (node, group)}
                       for values in (*sets, defaults)]
        ours = present.get(node, {})
        if group != LAW and not any(gains and all(ours.get(name) == value for name, value in gains.items())
                                    for gains in known_gains):
            users.add((node, group))
    return users


def law_note(sources: ParameterSources) -> str:
    """
    Return a line on a law that a single parameter selects without the other gains of its shipped set.

    Parameters
    ----------
    sources : ParameterSources
        Of the run. What its single parameters set is meant so.

    Returns
    -------
    str
        '' if none selects the law, or all its gains are those of the set.

    Raises
    ------
    ParameterError
        If the parameters are refused.

    """
    meant = {name for override in sources.overrides for name in read_override(override)[2]}
    if LAW not in meant:
        return ''
    configuration = sources.configuration()
    present = {node: _listed(part) for node, part in configuration._asdict().items()}
    law = configuration.position_controller.control.controller_type
    law_set = set_for(law, present)
    if law_set is None:
        return ''
    return _words(law_set, present, meant, f'take them with --params-file {law_set.given}')


def node_note(law: str, group: object) -> str:
    """
    Return a line on a law that a running position controller takes up without the gains of its shipped set.

    Parameters
    ----------
    law : str
        Taken up.
    group : NamedTuple
        Parameters of the position controller, which knows no gains of other nodes.

    Returns
    -------
    str
        '' if its gains are those of the set, or the set is for another robot, for other rates or for lockstep alone.

    """
    own = _listed(group)
    # on the wall clock a robot may drive meanwhile, and no set is for it
    law_set = shipped_set(law) if own['lockstep'] else None
    if law_set is None or not _fits(law_set, own):
        return ''
    return _words(law_set, {POSITION: own}, set(), 'choose the law on the live page, which sets them and the velocity '
                  f'gains, or start all nodes with --params-file {law_set.given}')


def _words(law_set: LawSet, present: Present, meant: set[str], remedy: str) -> str:
    """Return a line on the groups of a set that differ from present ones, or '' if only parameters meant so do."""
    groups = sorted({_group(node, name) for node, values in differing(law_set, present).items() for name in values
                     if name not in meant})
    if not groups:
        return ''
    return (f'{LAW} = {law_set.law} changes the law alone: {" and ".join(f"{node}.{group}" for node, group in groups)} '
            f'{"differs" if len(groups) == 1 else "differ"} from {law_set.given}; {remedy}')
