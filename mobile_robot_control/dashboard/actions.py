"""What the page may ask for, each request checked and answered in words."""

import asyncio
import json
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.dashboard.disturbances import DISTURBANCES
from mobile_robot_control.dashboard.lessons import chapter_numbers, surface_numbers
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.path_drawing import MOST, on_a_path, planned, start_of
from mobile_robot_control.dashboard.recordings import BusyError, Recordings, save_parameters
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.system.files import explain
from mobile_robot_control.system.texts import describe_error, shortened

_MOST = 50
"""Parameters that one request may name."""


_LIMITS = ('timing.max_linear_velocity', 'timing.max_wheel_torque')
"""That a page sets along with a path."""
_PATIENCE, _LOOK = 3.0, 0.05
"""[s] of wall time until a cart has taken a path over or refused it, and between two looks."""
_AT_ONCE = {'period'}
"""What changes where the cart is, without a new run."""


class Answer(NamedTuple):
    """Whether a request was fulfilled, and the words for it."""

    good: bool
    text: str


class RefusedRequestError(ValueError):
    """A request that makes no sense; the text says why."""


def _drawn(request: Mapping[str, Any]) -> tuple[list[tuple[float, float]], dict[str, float]]:
    """Return the points [m] and the limits of a request."""
    points, limits = request.get('points'), request.get('limits')
    if not (isinstance(points, list) and 1 < len(points) <= MOST and all(
            isinstance(point, list) and len(point) == 2 and all(type(part) in (int, float) for part in point)
            for point in points)):
        raise RefusedRequestError(f'a path has 2 to {MOST} points')
    if not (isinstance(limits, dict) and all(
            name in _LIMITS and type(limit) in (int, float) for name, limit in limits.items())):
        raise RefusedRequestError(f'a path has limits of {" and ".join(_LIMITS)}')
    return [(float(x), float(y)) for x, y in points], {name: float(limit) for name, limit in limits.items()}


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

    """

    def __init__(self, link: RobotLink, recordings: Recordings, saved: Path) -> None:
        self._link, self._recordings, self._saved = link, recordings, saved
        self._handlers: dict[str, Callable[[Mapping[str, Any]], Awaitable[Answer]]] = {
            'set': self._set, 'save': self._save, 'record': self._record,
            'finish': self._finish, 'reset': self._reset, 'step': self._step,
            'curve': self._curve, 'disturb': self._disturb,
            'lesson': self._lesson, 'plan': self._plan, 'path': self._path,
        }

    async def fulfil(self, request: Any) -> Answer:
        """Fulfil a request as JSON has it, whatever it holds; never raises."""
        try:
            asked = request.get('do') if isinstance(request, dict) else None
            if not isinstance(asked, str) or asked not in self._handlers:
                raise RefusedRequestError('the page asked for something that is not there; load it again')
            return await self._handlers[asked](request)
        except (NoAnswerError, RefusedRequestError, BusyError) as error:
            return Answer(False, shortened(str(error)))
        except OSError as error:
            return Answer(False, shortened(explain(error)))
        except ParameterError as error:
            return Answer(False, shortened('; '.join(error.violations), 1000))
        except Exception as error:  # whatever a page sends must not end the server
            return Answer(False, describe_error(error))

    async def _ask(self, job: Callable[[], Any]) -> Any:
        return await asyncio.wrap_future(self._link.submit(job))

    async def _set(self, request: Mapping[str, Any]) -> Answer:
        node, values = request.get('node'), request.get('values')
        if not isinstance(node, str) or not isinstance(values, dict) or not 0 < len(values) <= _MOST:
            raise RefusedRequestError('a change names a node, and values by name')

        def send() -> Future[str]:
            return self._link.book.set(node, values)

        refused = await self._ask(send)
        return Answer(not refused, refused)

    async def _step(self, _: Mapping[str, Any]) -> Answer:
        return await self._trigger('step')

    async def _reset(self, request: Mapping[str, Any]) -> Answer:
        """Begin a new run, from a pose [x, y, heading] where the request has one."""
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
        """Change the curve or its placement; where the robot is simulated, begin a new run at the cart's start."""
        changed = await self._set({'node': 'reference_cart', 'values': request.get('values')})
        if not changed.good or set(request['values']) <= _AT_ONCE:
            return changed
        values = (await self._present()).get('reference_cart', {}) | request['values']
        if values.get('curve') not in CURVES:
            # one that only the cart has loaded
            return await self._reset({})
        start = reference_at(CURVES[values['curve']], 0.0, Placement(*(values[name] for name in Placement._fields)))
        return await self._reset({'pose': list(start.pose)})

    async def _plan(self, request: Mapping[str, Any]) -> Answer:
        """Answer with the plan of a path, as JSON."""
        points, limits = _drawn(request)
        values = (await self._present()).get('reference_cart', {})
        return Answer(True, json.dumps(await asyncio.to_thread(planned, values, points, limits)))

    async def _path(self, request: Mapping[str, Any]) -> Answer:
        """Send a path to the cart, in a new run at its start where the cart drives a curve or its limits change."""
        points, limits = _drawn(request)
        values = (await self._present()).get('reference_cart', {})
        await asyncio.to_thread(planned, values, points, limits)
        changes = on_a_path(values, limits)
        if changes:
            before = await self._course_changes()
            changed = await self._set({'node': 'reference_cart', 'values': changes})
            if not changed.good:
                return changed
            begun = await self._reset({'pose': start_of(points)})
            if not begun.good:
                return begun
            if await self._changed_course(before) is None:
                return Answer(False, 'no new run began; is the cart running?')
        before = await self._course_changes()
        await self._ask(lambda: self._link.paths.send(points, values['odom_frame_id']))
        after = await self._changed_course(before)
        if after is None:
            return Answer(True, 'sent; the cart takes it over when time goes on')
        refused = [reason for reason in after if reason.startswith('path: ') and after[reason] > before.get(reason, 0)]
        return Answer(not refused, f'refused {refused[0]}; the log of the cart tells why' if refused else '')

    async def _course_changes(self) -> Counter[str]:
        """Return how often the cart has changed its course or refused a path, by event or reason."""
        def look() -> Counter[str]:
            known = self._link.book.nodes.get('reference_cart')
            states = self._link.states.of([known.name]) if known else []
            events = {key: count for (node, key), count in self._link.events.counts.items() if node == 'reference_cart'}
            return Counter(events | {reason: count for state in states for reason, count in state['reasons'].items()})

        found: Counter[str] = await self._ask(look)
        return found

    async def _changed_course(self, before: Counter[str]) -> Counter[str] | None:
        """Wait for another count of changes, and return it; None where none comes."""
        for _ in range(round(_PATIENCE / _LOOK)):
            await asyncio.sleep(_LOOK)
            found = await self._course_changes()
            if found != before:
                return found
        return None

    async def _trigger(self, service: str) -> Answer:
        """Call a service of the plant."""
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

    async def _lesson(self, _: Mapping[str, Any]) -> Answer:
        """Answer with the numbers of the lessons, as JSON."""
        values = (await self._present()).get('position_controller', {})
        numbers = await asyncio.to_thread(lambda: {'chapter': chapter_numbers(), 'surface': surface_numbers(values)})
        return Answer(True, json.dumps(numbers))

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
