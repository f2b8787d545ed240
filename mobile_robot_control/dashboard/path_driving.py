"""Paths that the cart is to follow: in a new run at their start, or taken over by a cart that drives one."""

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.publishing import SketchPoint, path_changes, path_preview, sketch_poses
from mobile_robot_control.dashboard.service_calls import Answer, RefusedRequestError
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.path_parameters import NO_FILE

_PATIENCE, _LOOK = 8.0, 0.05
"""[s] of wall time for a cart to accept a path or refuse it, and between two checks."""
_HELD = 3.0
"""[s] of wall time for the same while time stands: a path may have to wait for its next tick."""


class PathDriver:
    """
    Sends paths to the cart, and remembers the last one and the last sketched one.

    Parameters
    ----------
    link : RobotLink
        To the robot.
    present, change, begin_run : callable
        As those of `RobotAccess`; `begin_run` is its `reset`.

    """

    def __init__(
        self, link: RobotLink, present: Callable[[], Awaitable[dict[str, dict[str, Any]]]],
        change: Callable[[str, Mapping[str, Any]], Awaitable[None]],
        begin_run: Callable[[Sequence[float] | None], Awaitable[int]],
    ) -> None:
        self._link, self._present, self._change, self._begin_run = link, present, change, begin_run
        self._sketched: Sequence[SketchPoint] = ()
        self._last: Sequence[SketchPoint] = ()

    async def path(self, points: list[SketchPoint], limits: Mapping[str, float]) -> Answer:
        """Send a sketched path to the cart, in a new run at its start if the cart drives a curve or limits change."""
        values = (await self._present()).get('reference_cart', {})
        await asyncio.to_thread(path_preview, values, points, limits)
        self._sketched = points
        if path_changes(values, points, limits):
            return (await self._drive(points, limits))[1]
        return await self._send_path(points)

    async def _drive(self, points: Sequence[SketchPoint], limits: Mapping[str, float]) -> tuple[int, Answer]:
        """Begin a new run along a path within limits; return its number, and what the cart answers."""
        changes = path_changes((await self._present()).get('reference_cart', {}), points, limits)
        before = await self._course_changes()
        if changes:
            await self._change('reference_cart', changes)
        number = await self._begin_run(sketch_poses(points)[0])
        if changes and await self._changed_course(before) is None:
            raise RefusedRequestError('no new run began; is the cart running?')
        return number, await self._send_path(points)

    async def _send_path(self, points: Sequence[SketchPoint]) -> Answer:
        """Send a path to the cart."""
        self._last = points
        frame = (await self._present())['reference_cart']['odom_frame_id']
        before = await self._course_changes()
        await asyncio.wrap_future(self._link.submit(lambda: self._link.paths.send(points, frame)))
        after = await self._changed_course(before)
        if after is None:
            return Answer(True, 'sent; the cart starts it when time resumes')
        refused = [reason for reason in after if reason.startswith('path: ') and after[reason] > before.get(reason, 0)]
        return Answer(not refused, f'refused {refused[0]}; the log of the cart has the reason' if refused else '')

    async def follow(self, points: Sequence[Sequence[float]], limits: Mapping[str, float]) -> int:
        """Begin a new run along the path of a lesson; return its number."""
        number, answer = await self._drive([SketchPoint(x, y) for x, y in points], limits)
        if not answer.good:
            raise RefusedRequestError(answer.text)
        return number

    async def resume(self) -> None:
        """Send the last sketched path again, if the cart awaits it after a lesson."""
        self._last = self._sketched
        if await self._is_awaited():
            await self._send_path(self._last)

    async def _is_awaited(self) -> bool:
        """Return whether a new run of the cart awaits a path, and the page has sent one."""
        cart = (await self._present()).get('reference_cart', {})
        return bool(self._last) and cart.get('curve') == PATH and cart.get('path.file') == NO_FILE

    async def run_again(self, pose: Sequence[float] | None) -> Answer | None:
        """Begin a new run along the last path, from a pose as `begin_run` takes it; None if the cart needs none."""
        lockstep = (await self._present()).get('plant', {}).get('lockstep') is True
        # on the wall clock a reset moves the robot alone, and the cart keeps its path
        if not (lockstep and await self._is_awaited()):
            return None
        await self._begin_run(pose)
        return await self._send_path(self._last)

    async def _course_changes(self) -> Counter[str]:
        """Return the number of course changes, refused paths and unchanged plans of the cart, by event or reason."""
        def look() -> Counter[str]:
            cart = self._link.book.nodes.get('reference_cart')
            states = self._link.states.of([cart.name]) if cart else []
            events = {key: count for (node, key), count in self._link.events.counts.items() if node == 'reference_cart'}
            return Counter(events | {name: count for state in states for name, count in (
                *state['reasons'].items(), ('unchanged', state['unchanged']))})

        changes: Counter[str] = await asyncio.wrap_future(self._link.submit(look))
        return changes

    async def _changed_course(self, before: Counter[str]) -> Counter[str] | None:
        """Wait for a new count of changes, and return it; None if none comes."""
        plant = (await self._present()).get('plant', {})
        for _ in range(round((_HELD if plant.get('paused') or plant.get('hold_at') else _PATIENCE) / _LOOK)):
            await asyncio.sleep(_LOOK)
            changes = await self._course_changes()
            if changes != before:
                return changes
        return None
