"""Lessons of the live page: files by a teacher, read and checked."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobile_robot_control.dashboard.sampling import COLUMNS
from mobile_robot_control.parameters.declaration import ParameterError, declarations, nearest
from mobile_robot_control.reference.path_parameters import Timing
from mobile_robot_control.settings.configure import shipped_folder
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.system.files import PARAMETER_FILE, explain, read_bounded
from mobile_robot_control.system.texts import shortened

POSE = ('ahead', 'left', 'turn')
"""Of the robot at the start, in the frame of the cart's start [m, m, rad]."""
_CHARTS = ('errors', 'velocities', 'torques', 'lyapunov')
_PICTURES = ('fuzzy_surface',)
_MEASURES = ('now', 'mean', 'largest', 'farthest', 'accepted')
_MOST = 50


class Control(NamedTuple):
    """
    A control of a lesson.

    Attributes
    ----------
    sets : tuple of str
        'pose.ahead', 'plan.timing.max_wheel_torque', 'picture', or a node with its parameter.
    times : tuple of float
        Factor of its number for each of them.
    begins_run : bool
        Whether a change begins a new run.

    """

    sets: tuple[str, ...]
    times: tuple[float, ...]
    begins_run: bool


class Lesson(NamedTuple):
    """
    A lesson.

    Attributes
    ----------
    name : str
        Name of its file, without the suffix.
    content : dict
        As shown on the page.
    robots : tuple of str
        Robots with this lesson.
    pose : tuple of float or None
        Start of the robot, as POSE; None to continue from its present place.
    parameters : dict of str to dict of str to object
        Initial parameters by node.
    controls : tuple of Control
        In their order.

    """

    name: str
    content: dict[str, Any]
    robots: tuple[str, ...]
    pose: tuple[float, ...] | None
    parameters: dict[str, dict[str, Any]]
    controls: tuple[Control, ...]

    @property
    def begins_run(self) -> bool:
        """Whether it begins a run of its own: from a pose, or along a path."""
        return self.pose is not None or 'plan' in self.content

    def limits(self) -> dict[str, float]:
        """Return the first limits of its path, by parameter of the cart."""
        first = {}
        for control, content in zip(self.controls, self.content['controls'], strict=True):
            node, name = parameter_of(control.sets[0])
            if node == 'plan':
                first[name] = float(content.get('value', (content.get('range') or content.get('choices'))[0]))
        return first

    def touched(self) -> dict[str, set[str]]:
        """Return the changed parameters of the lesson by node."""
        names: dict[str, set[str]] = {node: set(values) for node, values in self.parameters.items()}
        for control in self.controls:
            for node, name in map(parameter_of, control.sets):
                if node in NODES or node == 'plan':
                    names.setdefault('reference_cart' if node == 'plan' else node, set()).add(name)
        return names

    def watched(self) -> dict[str, set[str]]:
        """Return the parameters of its controls and of its answer by node."""
        names = self.touched()
        for node, name in map(parameter_of, self.content['answer'].get('with') or ()):
            names.setdefault(node, set()).add(name)
        return names


def parameter_of(target: str) -> tuple[str, str]:
    """Return the node and the parameter of a control; '' and the name if it sets no parameter."""
    node, _, name = target.partition('.')
    return node, name


def read_lessons(folder: str) -> tuple[Lesson, ...]:
    """
    Read the lessons of a folder, in the order of their names.

    Parameters
    ----------
    folder : str
        '' for the lessons of this package.

    Raises
    ------
    ParameterError
        With every violation and its file.

    """
    place = Path(folder) if folder else shipped_folder('lessons')
    if place is None:
        return ()
    files = sorted(place.glob('*.yaml')) if place.is_dir() else []
    if not files:
        raise ParameterError([f'--lessons {folder}: there is no lesson in this folder; a lesson is a file NAME.yaml, '
                              'such as those in config/lessons'])
    lessons: list[Lesson] = []
    violations: list[str] = []
    for file in files:
        try:
            lessons.append(_read(file))
        except ParameterError as error:
            violations += error.violations
    if violations:
        raise ParameterError(violations)
    return tuple(lessons)


def _read(file: Path) -> Lesson:
    try:
        yaml_text = read_bounded(file, PARAMETER_FILE).decode()
    except OSError as error:
        raise ParameterError([explain(error)]) from error
    except UnicodeDecodeError as error:
        raise ParameterError([f'{file}: is not a text in UTF-8']) from error
    try:
        content = yaml.safe_load(yaml_text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a ValueError for a date such as 2001-99-99
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        raise ParameterError([f'{file}{where}: {getattr(error, "problem", None) or "not valid YAML"}']) from error
    violations = [f'{file}: {violation}' for violation in _violations(content)]
    if violations:
        raise ParameterError(violations)
    start = content.get('start') or {}
    controls = tuple(Control(tuple(one['sets']), tuple(one.get('times') or [1.0] * len(one['sets'])),
                             one.get('begins_run', False)) for one in content['controls'])
    pose = start.get('pose')
    return Lesson(file.stem, content, tuple(content['robots']), None if pose is None else tuple(map(float, pose)),
                  start.get('parameters') or {}, controls)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value.strip()) <= 2000


def _list_of(check: Callable[[Any], bool], least: int = 1, most: int = _MOST) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and least <= len(value) <= most and all(map(check, value))


def _one_of(names: Sequence[str]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, str) and value in names


_Keys = Mapping[str, tuple[Callable[[Any], bool], str]]
_TEXT = _is_text, 'a text of at most 2000 letters'
_COLUMN_LIST = _list_of(_one_of(COLUMNS), 0), f'a list of columns of the page: {", ".join(COLUMNS)}'
_LESSON: _Keys = {
    'title': _TEXT, 'text': _TEXT, 'question': _TEXT,
    'robots': (_list_of(_is_text), 'a list of names of robots, such as [chapter]'),
    'show': _COLUMN_LIST,
    'controls': (_list_of(lambda value: isinstance(value, dict), 1, 2), 'a list of one or two controls'),
    'answer': (lambda value: isinstance(value, dict), 'a mapping'),
}
_MAY: _Keys = {
    'start': (lambda value: isinstance(value, dict), 'a mapping with parameters and pose'),
    'chart': (_one_of(_CHARTS), f'one of {", ".join(_CHARTS)}'),
    'picture': (_one_of(_PICTURES), f'one of {", ".join(_PICTURES)}'),
    'plan': (_list_of(_list_of(_is_number, 2, 2), 2), 'a list of points [x, y] in m'),
}
_CONTROL: _Keys = {'label': _TEXT, 'sets': (_list_of(_is_text), 'a list such as [plant.paused] or [pose.ahead]')}
_CONTROL_MAY: _Keys = {
    'unit': _TEXT, 'times': (_list_of(_is_number), 'a list of numbers'),
    'range': (_list_of(_is_number, 3, 3), 'low, high and step'),
    'choices': (_list_of(lambda value: _is_text(value) or _is_number(value), 2), 'a list of two values or more'),
    'value': (lambda value: _is_text(value) or _is_number(value), 'a text or a number'),
    'begins_run': (lambda value: isinstance(value, bool), 'true or false'),
}
_ALWAYS: _Keys = {'right': _TEXT, 'wrong': _TEXT, 'hint': _TEXT, 'kind': _TEXT, 'unit': _TEXT}
_MEASURED: _Keys = {
    'measure': (_one_of(_MEASURES), f'one of {", ".join(_MEASURES)}'),
}
_MEASURED_MAY: _Keys = {
    'of': _COLUMN_LIST,
    'over': (lambda value: value == 'lap' or (_is_number(value) and value > 0) or _list_of(_is_number, 2, 2)(value),
             "seconds before now, two times of the run such as [0.0, 10.0], or 'lap'"),
    'tolerance': (lambda value: _is_number(value) and value > 0, 'a number above 0'),
    'share': (lambda value: _is_number(value) and value > 0, 'a number above 0: of what is measured'),
    'with': (lambda value: isinstance(value, dict), 'values that parameters must have, such as plant.paused: false'),
}
_KINDS: dict[str, tuple[_Keys, _Keys]] = {
    'place': ({'reach': (lambda value: isinstance(value, dict) and bool(value) and all(map(_is_number, value.values()))
                         and set(value) <= set(COLUMNS), 'numbers by column'),
               'tolerance': _MEASURED_MAY['tolerance']}, {}),
    'number': (_MEASURED, _MEASURED_MAY),
    'larger': ({**_MEASURED, 'choices': (_list_of(_is_text, 2, 2), 'two values of the first control')}, _MEASURED_MAY),
    'plan': ({'limit': _TEXT, 'choices': (_list_of(_is_text, 3, 3), 'three texts: bends, straights, both')}, {}),
}


def _violations(content: Any) -> Iterator[str]:
    if not isinstance(content, dict):
        yield 'is no lesson: it must be a mapping with title, text, robots, controls, question and answer'
        return
    wrong = list(_of_keys(content, _LESSON, _MAY, ''))
    yield from wrong
    if wrong:
        return
    start = content.get('start') or {}
    yield from _of_keys(start, {}, {'parameters': (lambda value: isinstance(value, dict), 'values by node'),
                                    'pose': (_list_of(_is_number, 3, 3), f'numbers: {", ".join(POSE)}')}, 'start.')
    for node, values in (start.get('parameters') or {}).items():
        for name in values if isinstance(values, dict) else ():
            yield from _of_parameter(f'{node}.{name}')
    for n, control in enumerate(content['controls'], 1):
        yield from _of_control(control, f'controls {n}: ', bool(content.get('plan')))
    yield from _of_answer(content['answer'], content)


def _of_keys(content: Mapping[str, Any], must: _Keys, may: _Keys, where: str) -> Iterator[str]:
    for name in must:
        if name not in content:
            yield f'{where}{name} is missing; write {must[name][1]}'
    for name, value in content.items():
        rule = {**must, **may}.get(name)
        if rule is None:
            yield f'{where}{shortened(str(name), 60)} is not known; {nearest(str(name), [*must, *may])}'
        elif not rule[0](value):
            yield f'{where}{name} = {shortened(str(value), 60)} must be {rule[1]}'


def _of_parameter(target: str) -> Iterator[str]:
    node, name = parameter_of(target)
    if node not in NODES:
        yield f"'{shortened(target, 80)}' names no node; begin with one of {', '.join(NODES)}"
    elif name not in declarations(NODES[node]):
        yield f"the node {node} has no parameter '{shortened(name, 60)}'; {nearest(name, declarations(NODES[node]))}"


def _of_control(control: dict[str, Any], where: str, plans: bool) -> Iterator[str]:
    wrong = list(_of_keys(control, _CONTROL, _CONTROL_MAY, where))
    yield from wrong
    if wrong:
        return
    if ('range' in control) == ('choices' in control):
        yield f'{where}write either range or choices'
    if len(control.get('times') or control['sets']) != len(control['sets']):
        yield f'{where}times must have a number for each of sets'
    for target in control['sets']:
        node, name = parameter_of(target)
        if node == 'pose' and name not in POSE:
            yield f"{where}'{target}' is no part of the start; write pose.{', pose.'.join(POSE)}"
        elif node == 'plan' and (not plans or name.removeprefix('timing.') not in Timing._fields):
            yield f"{where}'{target}' must be a limit such as plan.timing.max_wheel_torque, of a lesson with a plan"
        elif node not in ('pose', 'plan', 'picture'):
            yield from (f'{where}{text}' for text in _of_parameter(target))


def _of_answer(answer: dict[str, Any], content: Mapping[str, Any]) -> Iterator[str]:
    kind = answer.get('kind')
    if kind not in _KINDS:
        yield f'answer.kind = {shortened(str(kind), 40)} must be one of {", ".join(_KINDS)}'
        return
    must, may = _KINDS[kind]
    wrong = list(_of_keys(answer, must, {**may, **_ALWAYS}, 'answer.'))
    yield from wrong
    if wrong:
        return
    if 'measure' in must and answer['measure'] != 'accepted' and not (answer.get('of') and 'over' in answer):
        yield 'answer: write of (columns) and over (a time); without them nothing is measured'
    if kind == 'number' and not ('tolerance' in answer or 'share' in answer):
        yield 'answer: write a tolerance, or a share of what is measured'
    if kind == 'plan' and not content.get('plan'):
        yield 'answer.kind = plan needs the points of a plan'
    for target in answer.get('with') or ():
        yield from _of_parameter(str(target))
