"""A lesson under way: started with its own parameters, moved by its controls, and undone afterwards."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.control.fuzzy import FuzzyGains, surface
from mobile_robot_control.dashboard.law_choice import law_changes
from mobile_robot_control.dashboard.lesson_files import POSE, Lesson, parameter_of
from mobile_robot_control.parameters.declaration import build
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.files import Values
from mobile_robot_control.settings.law_sets import LAW, POSITION
from mobile_robot_control.settings.nodes import NODES

_COLUMNS, _ROWS = 48, 32
_FARTHEST = 1.0
"""[m]: distance at the right edge of the surface."""


def surface_numbers(values: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return the control surface of the fuzzy law.

    Parameters
    ----------
    values : mapping of str to object
        Parameters of the position controller.

    Returns
    -------
    dict of str to object
        `columns`, `rows`; `farthest` [m], the distance at the right edge, with 0 at the left one; `linear` [m/s] and
        `angular` [rad/s], row by row from a bearing of π down to -π.

    Raises
    ------
    ParameterError
        If the gains are not valid for the law.

    """
    gains = build(FuzzyGains, {name: values[f'fuzzy.{name}'] for name in FuzzyGains._fields
                               if f'fuzzy.{name}' in values})
    commands = [surface(_FARTHEST * (column + 0.5) / _COLUMNS, math.pi * (1.0 - (2.0 * row + 1.0) / _ROWS), gains)
                for row in range(_ROWS) for column in range(_COLUMNS)]
    return {'columns': _COLUMNS, 'rows': _ROWS, 'farthest': _FARTHEST,
            'linear': [round(command.linear, 4) for command in commands],
            'angular': [round(command.angular, 4) for command in commands]}


_PATIENCE, _LOOK = 10.0, 0.1
"""[s] of wall time for the nodes of a lesson to be discovered, and between two looks."""


def _joined(values: Values, others: Values) -> Values:
    """Return values by node in which others win."""
    return {node: {**values.get(node, {}), **others.get(node, {})} for node in (*values, *others)}


class LessonError(ValueError):
    """A lesson that cannot be played; the text is the reason."""


class RobotAccess(NamedTuple):
    """
    The interface of a robot to a lesson; each function raises if it is refused.

    Attributes
    ----------
    present : callable
        Returns the parameters by node.
    initial : callable
        Returns the initial values of the parameters that have others now, by node; {} if they are not known.
    change : callable
        Takes a node and its new values; restarts it if one of them is read-only while it runs.
    reset : callable
        Begins a new run from a pose [m, m, rad], or from that of the parameters for None; returns its number once its
        first row has come.
    follow : callable
        Begins a new run along points [m], within limits of the cart's `timing`; returns its number likewise.
    resume : callable
        Sends the last path of the page again, if the cart awaits one.

    """

    present: Callable[[], Awaitable[Values]]
    initial: Callable[[], Awaitable[Values]]
    change: Callable[[str, Mapping[str, Any]], Awaitable[None]]
    reset: Callable[[Sequence[float] | None], Awaitable[int]]
    follow: Callable[[Sequence[Sequence[float]], Mapping[str, float]], Awaitable[int]]
    resume: Callable[[], Awaitable[None]]


class Teaching:
    """
    Plays one lesson at a time, for all pages.

    Parameters
    ----------
    lessons : sequence of Lesson
        Available lessons.
    name : str
        Of the robot; '' if unknown.
    robot : RobotAccess
        Of the lessons.

    Attributes
    ----------
    lessons : dict of str to Lesson
        By name.
    running : str
        Name of the lesson under way; '' for none.

    """

    def __init__(self, lessons: Sequence[Lesson], name: str, robot: RobotAccess) -> None:
        self.lessons = {lesson.name: lesson for lesson in lessons}
        self._name, self._robot = name, robot
        self.running = ''
        self._whose: object = None
        self._before: Values = {}
        self._touched: dict[str, set[str]] = {}
        self._pose: dict[str, float] = {}
        self._limits: dict[str, float] = {}
        self._lock = asyncio.Lock()

    def shown(self) -> list[dict[str, Any]]:
        """Return the lessons for the page, each with whether it is for this robot."""
        return [{'name': lesson.name, 'fits': not self._name or self._name in lesson.robots, **lesson.content}
                for lesson in self.lessons.values()]

    def watched(self) -> dict[str, set[str]]:
        """Return the parameters that count for the lesson under way, by node."""
        return self.lessons[self.running].watched() if self.running else {}

    async def begin(self, name: str, whose: object) -> int:
        """
        Begin a lesson; return the number of its run, 0 if it begins none.

        Raises LessonError if there is no lesson of that name, or it is not for this robot.
        """
        lesson = self.lessons.get(name)
        if lesson is None:
            raise LessonError('there is no such lesson; load the page again')
        if self._name and self._name not in lesson.robots:
            raise LessonError(f'this lesson is for {", ".join(lesson.robots)}, and the robot here is {self._name}; '
                             f'start dashboard --robot {lesson.robots[0]}')
        async with self._lock:
            await self._take_back()
            self._before = await self._nodes_of(lesson)
            self.running, self._whose, self._touched = name, whose, {}
            self._pose = dict(zip(POSE, lesson.pose or (0.0,) * 3, strict=True))
            self._limits = lesson.limits()
            await self._set(lesson.parameters, await self._robot.initial())
            return await self._begin_run() if lesson.begins_run else 0

    async def _nodes_of(self, lesson: Lesson) -> Values:
        """Return the present parameters, once the nodes of a lesson are there: a page may be open before them."""
        waited = 0.0
        while True:
            present = await self._robot.present()
            absent = [node for node in lesson.touched() if node not in present]
            if not absent:
                return present
            if waited >= _PATIENCE:
                raise LessonError(f'this lesson handles the node {" and ".join(absent)}, which is not there')
            await asyncio.sleep(_LOOK)
            waited += _LOOK

    async def move(self, number: int, value: Any) -> int:
        """Set a control of the lesson under way, counted from 0; return the number of the run that it begins, or 0."""
        async with self._lock:
            controls = self.lessons[self.running].controls if self.running else ()
            if not 0 <= number < len(controls):
                raise LessonError('the lesson has ended; begin it again')
            control, changes = controls[number], Values()
            for target, factor in zip(control.sets, control.times, strict=True):
                node, name = parameter_of(target)
                target_value = value if isinstance(value, str) else float(value) * factor
                if node == 'pose':
                    self._pose[name] = float(target_value)
                elif node == 'plan':
                    self._limits[name] = float(target_value)
                elif node in NODES:
                    changes.setdefault(node, {})[name] = target_value
            await self._set(changes)
            begins = control.begins_run or any(target.startswith(('pose.', 'plan.')) for target in control.sets)
            return await self._begin_run() if begins else 0

    async def end(self, whose: object = None) -> None:
        """Undo the changes of the lesson; for a closed page, only of a lesson that it began."""
        async with self._lock:
            if self.running and (whose is None or whose is self._whose):
                await self._take_back()
                await self._robot.resume()

    async def _set(self, changes: Values, initial: Values | None = None) -> None:
        """Change parameters by node: to initial values, over them to the set of a law, over it to the changes."""
        present, below = await self._robot.present(), initial or {}
        law = changes.get(POSITION, {}).get(LAW)
        if law is not None:
            below = _joined(below, law_changes(law, _joined(present, below), whole=True))
        for node, values in _joined(below, changes).items():
            unlike = {name: value for name, value in values.items() if present.get(node, {}).get(name) != value}
            self._touched.setdefault(node, set()).update(unlike)
            if unlike:
                await self._robot.change(node, unlike)

    async def _begin_run(self) -> int:
        """Begin a new run along the lesson's path, or beside the cart's start."""
        points = self.lessons[self.running].content.get('plan')
        if points:
            self._touched.setdefault('reference_cart', set()).update(('curve', *Placement._fields, *self._limits))
            return await self._robot.follow(points, self._limits)
        values = (await self._robot.present())['reference_cart']
        curve = CURVES.get(values.get('curve', ''))
        if curve is None:
            raise LessonError('the start of this curve is not known here; choose a curve of this package')
        start = reference_at(curve, 0.0, Placement(*(values[name] for name in Placement._fields))).pose
        ahead, left, turn = (self._pose[name] for name in POSE)
        cos, sin = math.cos(start.heading), math.sin(start.heading)
        return await self._robot.reset([start.x + ahead * cos - left * sin, start.y + ahead * sin + left * cos,
                                        start.heading + turn])

    async def _take_back(self) -> None:
        """Restore the values that the lesson changed, and begin a new run there."""
        if not self.running:
            return
        lesson, before, touched = self.lessons[self.running], self._before, self._touched
        present = await self._robot.present()
        if lesson.begins_run:
            touched.setdefault('plant', set()).add('initial_pose')
        try:
            for node, names in touched.items():
                former, now = before.get(node, {}), present.get(node, {})
                changed = {name: former[name] for name in sorted(names)
                           if name in former and now.get(name) != former[name]}
                if changed:
                    await self._robot.change(node, changed)
            if lesson.begins_run:
                await self._robot.reset(None)
        finally:
            self.running, self._whose = '', None
