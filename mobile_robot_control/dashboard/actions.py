"""The requests of a page, each checked and answered in words."""

import asyncio
import json
import signal
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.dashboard.lesson_files import Lesson
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.publishing import DISTURBANCES, MOST, Drawn, headed, on_a_path, planned
from mobile_robot_control.dashboard.recordings import STATE, BusyError, Recordings, save_parameters
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.dashboard.started_nodes import StartedNodes
from mobile_robot_control.dashboard.teaching import LessonError, RobotAccess, Teaching, surface_numbers
from mobile_robot_control.parameters.declaration import ParameterError, declarations
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.system.files import explain
from mobile_robot_control.system.texts import describe_error, shortened

_MOST = 50
"""Most parameters in one request."""


_LIMITS = ('timing.max_linear_velocity', 'timing.max_wheel_torque', 'timing.max_angular_velocity')
"""Parameters that a page sets along with a path."""
_PATIENCE, _LOOK = 8.0, 0.05
"""[s] of wall time for a cart to accept a path or refuse it, and between two checks."""
_HELD = 3.0
"""[s] of wall time for the same while time stands: a path may have to wait for its next tick."""
_START = 20.0
"""[s] of wall time for a node to start again."""
_AT_ONCE = {'period'}
"""Parameters that act at the cart's present place, without a new run."""


class Answer(NamedTuple):
    """Whether a request was fulfilled, and a text."""

    good: bool
    text: str


class RefusedRequestError(ValueError):
    """A meaningless request; the text is the reason."""


def _drawn(request: Mapping[str, Any]) -> tuple[list[Drawn], dict[str, float]]:
    """Return the points and the limits of a request."""
    points, limits = request.get('points'), request.get('limits')
    if not (isinstance(points, list) and 1 < len(points) <= MOST and all(
            isinstance(point, list) and len(point) in (2, 3) and all(type(part) in (int, float) for part in point[:2])
            and all(isinstance(mark, str) for mark in point[2:]) for point in points)):
        raise RefusedRequestError(f'a path has 2 to {MOST} points')
    if not (isinstance(limits, dict) and all(
            name in _LIMITS and type(limit) in (int, float) for name, limit in limits.items())):
        raise RefusedRequestError(f'a path has limits of {" and ".join(_LIMITS)}')
    return ([Drawn(float(x), float(y), *mark) for x, y, *mark in points],
            {name: float(limit) for name, limit in limits.items()})


class Actions:
    """
    Fulfils the requests of all pages.

    Parameters
    ----------
    link : RobotLink
        To the robot.
    recordings : Recordings
        Of the page.
    saved : Path
        Folder for saved parameters.
    nodes : StartedNodes or None
        Nodes that this page has started; None if it is attached to others.
    lessons : sequence of Lesson
        Available lessons.
    robot : str
        Name of the robot; '' if unknown.
    reads_laws : bool
        Whether the files of laws may be read again.

    Attributes
    ----------
    teaching : Teaching
        The lesson under way.

    """

    def __init__(
        self, link: RobotLink, recordings: Recordings, saved: Path, nodes: StartedNodes | None = None,
        lessons: Sequence[Lesson] = (), robot: str = '', reads_laws: bool = False,
    ) -> None:
        self._link, self._recordings, self._saved, self._nodes = link, recordings, saved, nodes
        self._reads_laws = reads_laws and nodes is not None
        self._setting = asyncio.Lock()
        self.teaching = Teaching(lessons, robot, RobotAccess(self._present, self._change, self._begin_run))
        self._handlers: dict[str, Callable[[Mapping[str, Any]], Awaitable[Answer]]] = {
            'set': self._set, 'save': self._save, 'record': self._record,
            'finish': self._finish, 'reset': self._reset, 'step': self._step,
            'curve': self._curve, 'disturb': self._disturb,
            'surface': self._surface, 'plan': self._plan, 'path': self._path, 'restart': self._restart,
            'defaults': self._defaults, 'read_law': self._read_law, 'move': self._move, 'end': self._end,
        }

    async def fulfil(self, request: Any, whose: object = None) -> Answer:
        """Fulfil a request from JSON, with any content, for the page that sent it; never raises."""
        try:
            asked = request.get('do') if isinstance(request, dict) else None
            if asked == 'lesson':
                return Answer(True, str(await self.teaching.begin(str(request.get('name')), whose)))
            if not isinstance(asked, str) or asked not in self._handlers:
                raise RefusedRequestError('unknown request of the page; load it again')
            return await self._handlers[asked](request)
        except (NoAnswerError, RefusedRequestError, LessonError, BusyError) as error:
            return Answer(False, shortened(str(error)))
        except OSError as error:
            return Answer(False, shortened(explain(error)))
        except ParameterError as error:
            return Answer(False, shortened('; '.join(error.violations), 1000))
        except Exception as error:  # no request of a page may end the server
            return Answer(False, describe_error(error))

    async def _ask(self, job: Callable[[], Any]) -> Any:
        return await asyncio.wrap_future(self._link.submit(job))

    async def _set(self, request: Mapping[str, Any]) -> Answer:
        node, values = request.get('node'), request.get('values')
        if not isinstance(node, str) or not isinstance(values, dict) or not 0 < len(values) <= _MOST:
            raise RefusedRequestError('a change names a node, and values by name')

        def send() -> Future[str]:
            return self._link.book.set(node, values)

        # one after another, of whichever page: each stops the node for a moment
        async with self._setting:
            refused = await self._ask(send)
        return Answer(not refused, refused)

    async def _step(self, _: Mapping[str, Any]) -> Answer:
        return await self._trigger('step')

    async def _reset(self, request: Mapping[str, Any]) -> Answer:
        """Begin a new run, from the pose [x, y, heading] in the request if there is one."""
        if 'pose' in request:
            changed = await self._set({'node': 'plant', 'values': {'initial_pose': request['pose']}})
            if not changed.good:
                return changed
        return await self._trigger('reset')

    async def _disturb(self, request: Mapping[str, Any]) -> Answer:
        key = request.get('key')
        if not isinstance(key, str) or key not in DISTURBANCES:
            raise RefusedRequestError('a disturbance names an arrow key')

        def push() -> Future[str]:
            return self._link.disturbances.push(key)

        return Answer(True, await self._ask(push))

    async def _curve(self, request: Mapping[str, Any]) -> Answer:
        """Change the curve or its placement; with a simulated robot, begin a new run at the cart's start."""
        changed = await self._set({'node': 'reference_cart', 'values': request.get('values')})
        if not changed.good or set(request['values']) <= _AT_ONCE:
            return changed
        values = (await self._present()).get('reference_cart', {}) | request['values']
        if values.get('curve') not in CURVES:
            # a curve that only the cart has loaded
            return await self._reset({})
        start = reference_at(CURVES[values['curve']], 0.0, Placement(*(values[name] for name in Placement._fields)))
        return await self._reset({'pose': list(start.pose)})

    async def _plan(self, request: Mapping[str, Any]) -> Answer:
        """Answer with the plan of a path, as JSON."""
        points, limits = _drawn(request)
        values = (await self._present()).get('reference_cart', {})
        return Answer(True, json.dumps(await asyncio.to_thread(planned, values, points, limits)))

    async def _path(self, request: Mapping[str, Any]) -> Answer:
        """Send a path to the cart, in a new run at its start if the cart drives a curve or its limits change."""
        points, limits = _drawn(request)
        values = (await self._present()).get('reference_cart', {})
        await asyncio.to_thread(planned, values, points, limits)
        changes = on_a_path(values, points, limits)
        if changes:
            before = await self._course_changes()
            changed = await self._set({'node': 'reference_cart', 'values': changes})
            if not changed.good:
                return changed
            begun = await self._reset({'pose': list(headed(points)[0])})
            if not begun.good:
                return begun
            if await self._changed_course(before) is None:
                return Answer(False, 'no new run began; is the cart running?')
        before = await self._course_changes()
        await self._ask(lambda: self._link.paths.send(points, values['odom_frame_id']))
        after = await self._changed_course(before)
        if after is None:
            return Answer(True, 'sent; the cart starts it when time resumes')
        refused = [reason for reason in after if reason.startswith('path: ') and after[reason] > before.get(reason, 0)]
        return Answer(not refused, f'refused {refused[0]}; the log of the cart has the reason' if refused else '')

    async def _course_changes(self) -> Counter[str]:
        """Return the number of course changes and refused paths of the cart, by event or reason."""
        def look() -> Counter[str]:
            known = self._link.book.nodes.get('reference_cart')
            states = self._link.states.of([known.name]) if known else []
            events = {key: count for (node, key), count in self._link.events.counts.items() if node == 'reference_cart'}
            return Counter(events | {reason: count for state in states for reason, count in state['reasons'].items()})

        found: Counter[str] = await self._ask(look)
        return found

    async def _changed_course(self, before: Counter[str]) -> Counter[str] | None:
        """Wait for a new count of changes, and return it; None if none comes."""
        plant = (await self._present()).get('plant', {})
        for _ in range(round((_HELD if plant.get('paused') or plant.get('hold_at') else _PATIENCE) / _LOOK)):
            await asyncio.sleep(_LOOK)
            found = await self._course_changes()
            if found != before:
                return found
        return None

    async def _trigger(self, service: str) -> Answer:
        def call() -> Future[Any]:
            return self._link.book.trigger('plant', service)

        response = await self._ask(call)
        return Answer(bool(response.success), shortened(response.message))

    async def _present(self) -> dict[str, dict[str, Any]]:
        """Return the present values by node."""
        def look() -> dict[str, dict[str, Any]]:
            return {role: dict(known.values) for role, known in self._link.book.nodes.items() if known.entries}

        found: dict[str, dict[str, Any]] = await self._ask(look)
        return found

    async def _surface(self, _: Mapping[str, Any]) -> Answer:
        """Answer with the surface of the fuzzy law, as JSON."""
        values = (await self._present()).get('position_controller', {})
        return Answer(True, json.dumps(await asyncio.to_thread(surface_numbers, values)))

    async def _move(self, request: Mapping[str, Any]) -> Answer:
        """Set a control of the lesson under way."""
        number, value = request.get('control'), request.get('value')
        if type(number) is not int or not isinstance(value, str | int | float):
            raise RefusedRequestError('a control has a number and a value')
        return Answer(True, str(await self.teaching.move(number, value)))

    async def _end(self, _: Mapping[str, Any]) -> Answer:
        """End the lesson under way."""
        await self.teaching.end()
        return Answer(True, '')

    async def _change(self, node: str, values: Mapping[str, Any]) -> None:
        """Change parameters of a node; restart it if one of them is read-only while it runs."""
        def is_live(name: str) -> bool:
            known = self._link.book.nodes.get(node)
            return known is None or name not in known.entries or known.entries[name].live

        lasting = {name: value for name, value in values.items() if not await self._ask(partial(is_live, name))}
        present = (await self._present()).get(node, {})
        if any(present.get(name) != value for name, value in lasting.items()):
            await self._start_again(node, lasting)
        changes = {name: value for name, value in values.items() if name not in lasting}
        if changes:
            refused = await self._ask(lambda: self._link.book.set(node, changes, together=True))
            if refused:
                raise RefusedRequestError(refused)

    async def _begin_run(self, pose: Sequence[float] | None) -> int:
        """Begin a new run; return its number once its first row has come."""
        def number() -> int:
            return self._link.run.number

        def count_hidden_run() -> None:
            if sampler.run == counted and sampler.matched > matched:
                sampler.count_run()

        sampler = self._link.loop.sampler
        before, counted, matched = await self._ask(lambda: (number(), sampler.run, sampler.matched))
        begun = await self._reset({} if pose is None else {'pose': list(pose)})
        if not begun.good:
            raise RefusedRequestError(begun.text)
        for _ in range(round(_START / _LOOK)):
            found: int = await self._ask(number)
            if found > before:
                return found
            await self._ask(count_hidden_run)
            await asyncio.sleep(_LOOK)
        raise RefusedRequestError('no new run began; is the plant running?')

    async def _restart(self, request: Mapping[str, Any]) -> Answer:
        """Restart an ended node."""
        node = request.get('node')
        if not isinstance(node, str):
            raise RefusedRequestError('a node has a name')
        await self._start_again(node, {})
        return Answer(True, '')

    async def _start_again(self, node: str, changes: Mapping[str, Any]) -> None:
        """Restart a node with its present parameters and some changes, and wait until it is discovered."""
        if self._nodes is None:
            raise RefusedRequestError(f'this page has not started the {shortened(node, 60)}; start it yourself')

        def known() -> bytes:
            found = self._link.book.nodes.get(node)
            return found.endpoint if found is not None and found.entries and found.values else b''

        before, present = await self._ask(known), await self._present()
        present[node] = present.get(node, {}) | dict(changes)
        values = {role: {name: tuple(value) if isinstance(value, list) else value for name, value in found.items()
                         if value is not None and name not in STATE} for role, found in present.items()}
        await asyncio.to_thread(self._nodes.restart, node, values)
        for _ in range(round(_START / _LOOK)):
            await asyncio.sleep(_LOOK)
            if await self._ask(known) not in (b'', before):
                return
        raise RefusedRequestError(f'the {node} was started again, and has not answered for {_START:g} s')

    async def _defaults(self, _: Mapping[str, Any]) -> Answer:
        """Reset all live parameters to the initial ones of the nodes, and begin a new run there."""
        def changed() -> dict[str, dict[str, Any]]:
            return {role: {name: entry.default for name, entry in known.entries.items()
                           if entry.live and name not in STATE and entry.default is not None
                           and known.values.get(name) != entry.default}
                    for role, known in self._link.book.nodes.items()}

        await self.teaching.end()
        for node, values in (await self._ask(changed)).items():
            if values:
                answer = await self._set({'node': node, 'values': values})
                if not answer.good:
                    return answer
        return await self._reset({})

    async def _read_law(self, _: Mapping[str, Any]) -> Answer:
        """Read the changed files of `--law` again: first here, to find errors, then in the node."""
        if not self._reads_laws or self._nodes is None:
            raise RefusedRequestError('laws are read again for nodes that a page on this machine has started')
        before = {law.name: list(declarations(law.gains)) for law in LAWS.values()}
        read = await asyncio.to_thread(LAWS.load_changed)
        if not read:
            return Answer(True, 'no file has changed')
        if any(list(declarations(LAWS[name].gains)) != before.get(name) for name in read):
            await self._start_again('position_controller', {})
        else:
            self._nodes.signal('position_controller', signal.SIGUSR1)
        return Answer(True, f'read {", ".join(read)} again')

    def changed_laws(self) -> list[str]:
        """Return the names of the law files that have changed on disk."""
        return [Path(file).name for file in LAWS.changed_files()] if self._reads_laws else []

    async def _save(self, _: Mapping[str, Any]) -> Answer:
        present = await self._present()
        if not present:
            raise RefusedRequestError('no node has told its parameters yet')
        file = await asyncio.to_thread(save_parameters, self._saved, present)
        return Answer(True, file.name)

    async def _record(self, _: Mapping[str, Any]) -> Answer:
        present = await self._present()
        return Answer(True, await asyncio.to_thread(self._recordings.start, present))

    async def _finish(self, _: Mapping[str, Any]) -> Answer:
        return Answer(True, self._recordings.stop())
