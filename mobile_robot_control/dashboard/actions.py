"""What the page may ask for, each request checked and answered in words."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.dashboard.disturbances import DISTURBANCES
from mobile_robot_control.dashboard.lessons import chapter_numbers, surface_numbers
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.recordings import BusyError, Recordings, save_parameters
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.system.files import explain
from mobile_robot_control.system.texts import describe_error, shortened

_MOST = 50
"""Parameters that one request may name."""


_AT_ONCE = {'period'}
"""What changes where the cart is, without a new run."""


class Answer(NamedTuple):
    """Whether a request was fulfilled, and the words for it."""

    good: bool
    text: str


class RefusedRequestError(ValueError):
    """A request that makes no sense; the text says why."""


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
            'lesson': self._lesson,
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
