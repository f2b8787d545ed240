"""The requests of a page, each checked and answered in words."""

import asyncio
import json
import signal
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.dashboard.law_choice import LawChoice
from mobile_robot_control.dashboard.lesson_files import Lesson
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.path_driving import PathDriver
from mobile_robot_control.dashboard.publishing import DISTURBANCES, path_preview, sketch_of
from mobile_robot_control.dashboard.recordings import STATE, BusyError, PageRecordings, save_parameters
from mobile_robot_control.dashboard.service_calls import Answer, NoAnswerError, RefusedRequestError
from mobile_robot_control.dashboard.started_nodes import StartedNodes
from mobile_robot_control.dashboard.teaching import LessonError, RobotAccess, Teaching, surface_numbers
from mobile_robot_control.parameters.declaration import ParameterError, declarations
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.system.files import explain
from mobile_robot_control.system.texts import describe_error, shortened

_MOST = 50
"""Most parameters in one request."""
_START, _LOOK = 20.0, 0.05
"""[s] of wall time for a node to start again, and between two checks."""
_AT_ONCE = {'period'}
"""Parameters that act at the cart's present place, without a new run."""


class Actions:
    """
    Fulfils the requests of all pages.

    Parameters
    ----------
    link : RobotLink
        To the robot.
    recordings : PageRecordings
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
    law : LawChoice
        The last choice of a law.

    """

    def __init__(
        self, link: RobotLink, recordings: PageRecordings, saved: Path, nodes: StartedNodes | None = None,
        lessons: Sequence[Lesson] = (), robot: str = '', reads_laws: bool = False,
    ) -> None:
        self._link, self._recordings, self._saved, self._nodes = link, recordings, saved, nodes
        self._reads_laws = reads_laws and nodes is not None
        self._setting = asyncio.Lock()
        self.law = LawChoice(self._present, self._change)
        self._paths = PathDriver(link, self._present, self._change, self._begin_run)
        self.teaching = Teaching(lessons, robot, RobotAccess(
            self._present, self._initial, self._change, self._begin_run, self._paths.follow, self._paths.resume))
        self._handlers: dict[str, Callable[[Mapping[str, Any]], Awaitable[Answer]]] = {
            'set': self._set, 'save': self._save, 'record': self._record,
            'finish': self._finish, 'reset': self._new_run, 'step': self._step,
            'curve': self._curve, 'disturb': self._disturb,
            'surface': self._surface, 'plan': self._plan, 'path': self._path, 'restart': self._restart,
            'law': self._law, 'undo_law': self._undo_law,
            'defaults': self._defaults, 'read_law': self._read_law, 'move': self._move, 'end': self._end,
        }

    async def fulfil(self, request: Any, whose: object = None) -> Answer:
        """Fulfil a request from JSON, with any content, for the page that sent it; never raises."""
        try:
            action = request.get('do') if isinstance(request, dict) else None
            if action == 'lesson':
                return Answer(True, str(await self.teaching.begin(str(request.get('name')), whose)))
            if not isinstance(action, str) or action not in self._handlers:
                raise RefusedRequestError('unknown request of the page; load it again')
            return await self._handlers[action](request)
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

    async def _law(self, request: Mapping[str, Any]) -> Answer:
        """Change to a law, '' for the present one, with its shipped gains; with `whole`, also where others are set."""
        law = request.get('law')
        if not isinstance(law, str):
            raise RefusedRequestError('a law has a name')
        await self.law.choose(law, request.get('whole') is True)
        return Answer(True, '')

    async def _undo_law(self, _: Mapping[str, Any]) -> Answer:
        await self.law.undo()
        return Answer(True, '')

    async def _step(self, _: Mapping[str, Any]) -> Answer:
        return await self._trigger('step')

    async def _reset(self, request: Mapping[str, Any]) -> Answer:
        """Begin a new run, from the pose [x, y, heading] in the request if there is one."""
        if 'pose' in request:
            changed = await self._set({'node': 'plant', 'values': {'initial_pose': request['pose']}})
            if not changed.good:
                return changed
        return await self._trigger('reset')

    async def _new_run(self, request: Mapping[str, Any]) -> Answer:
        """Begin a new run as `_reset` does, along the last path of the page if the cart awaits one."""
        return await self._paths.run_again(request.get('pose')) or await self._reset(request)

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
        points, limits = sketch_of(request)
        values = (await self._present()).get('reference_cart', {})
        return Answer(True, json.dumps(await asyncio.to_thread(path_preview, values, points, limits)))

    async def _path(self, request: Mapping[str, Any]) -> Answer:
        """Send a path to the cart."""
        return await self._paths.path(*sketch_of(request))

    async def _trigger(self, service: str) -> Answer:
        def call() -> Future[Any]:
            return self._link.book.trigger('plant', service)

        response = await self._ask(call)
        return Answer(bool(response.success), shortened(response.message))

    async def _present(self) -> dict[str, dict[str, Any]]:
        """Return the present values by node."""
        def look() -> dict[str, dict[str, Any]]:
            return {role: dict(node.values) for role, node in self._link.book.nodes.items() if node.entries}

        present: dict[str, dict[str, Any]] = await self._ask(look)
        return present

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
            running = self._link.book.nodes.get(node)
            return running is None or name not in running.entries or running.entries[name].live

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
            newest: int = await self._ask(number)
            if newest > before:
                return newest
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
            running = self._link.book.nodes.get(node)
            return running.endpoint if running is not None and running.entries and running.values else b''

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

    async def _changed(self) -> dict[str, dict[str, Any]]:
        """Return the initial values of the live parameters that have others now."""
        def changed() -> dict[str, dict[str, Any]]:
            return {role: {name: entry.default for name, entry in running.entries.items()
                           if entry.live and name not in STATE and entry.default is not None
                           and running.values.get(name) != entry.default}
                    for role, running in self._link.book.nodes.items()}

        initial: dict[str, dict[str, Any]] = await self._ask(changed)
        return initial

    async def _initial(self) -> dict[str, dict[str, Any]]:
        """Return the same of nodes that this page has started; of others the initial values are not known."""
        return {} if self._nodes is None else await self._changed()

    async def _defaults(self, _: Mapping[str, Any]) -> Answer:
        """Reset all live parameters to the initial ones of the nodes, and begin a new run there."""
        await self.teaching.end()
        self.law.forget()
        for node, values in (await self._changed()).items():
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
