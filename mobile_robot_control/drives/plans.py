"""The paths that a drive is judged by: the plans of a bag, a file, or the recorded reference."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.messages.bag_files import BagFiles
from mobile_robot_control.messages.bag_messages import Message
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_or_refuse,
    read_path,
    read_transforms,
    serialised_stamp,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.waypoint_files import read_waypoints
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import is_bag, locate
from mobile_robot_control.settings.frames import Frames
from mobile_robot_control.system.texts import shortened

REFERENCE = 'reference'
"""In place of a topic or a file: the path that the reference of the run has driven."""
_PATH, _ODOMETRY = 'nav_msgs/msg/Path', 'nav_msgs/msg/Odometry'
_TF = ('/tf', '/tf_static')
_SAME_GOAL = 0.1
"""[m]: a plan that ends farther from the end of the one before is for another goal."""
_MOVES = 1e-4
"""[m] between two poses of a recorded reference."""
_LATE = 60.0
"""[s] outside of the recording at which the stamp of a plan is not believed."""


class GoalPlan(NamedTuple):
    """
    A path that a robot is to drive.

    Attributes
    ----------
    begin : float
        Time of its publication on the clock of the run [s]; -inf for a path that holds from the beginning.
    frame : str
        Of its poses; '' for that of odometry.
    poses : array of float, shape (m, 3)
        x, y [m] and heading [rad], nan where it has none.
    """

    begin: float
    frame: str
    poses: Floats


class Plans(NamedTuple):
    """
    The plans of one run.

    Attributes
    ----------
    goals : list of list of GoalPlan
        For each goal in turn its plans, the first one of which came with it.
    odometry : str
        Frame of odometry; '' if unknown.
    corrections : list of (float, Pose)
        Times on the clock of the run [s] and poses of the frame of odometry in that of the plans.
    missing : str
        What is missing for corrections, in words; '' where nothing is.
    """

    goals: list[list[GoalPlan]]
    odometry: str = ''
    corrections: Sequence[tuple[float, Pose]] = ()
    missing: str = ''


def plans_of(run: Run, place: Path, path: str, namespace: str, topics: Mapping[str, str]) -> Plans:
    """
    Return the plans that a run is judged by.

    Parameters
    ----------
    run : Run
        As read from its place.
    place : Path
        Of the run.
    path : str
        A file of waypoints, a topic of its bag, or REFERENCE.
    namespace : str
        Of the nodes.
    topics : mapping of str to str
        Other names of topics of the loop in the bag.

    Raises
    ------
    ParameterError
        If there is no path, with what there is instead.
    """
    if path == REFERENCE:
        return Plans([[_driven_reference(run)]])
    recorded = locate(place)
    bag = recorded if is_bag(recorded) else None
    if Path(path).is_file():
        waypoints = read_waypoints(path)
        headings = [np.nan if heading is None else heading for heading in waypoints.headings]
        poses = np.column_stack([waypoints.points, headings or np.full(len(waypoints.points), np.nan)])
        plan = GoalPlan(-np.inf, waypoints.frame, poses)
        held = _Recorded(run, bag, '', namespace, topics, waypoints.frame) if bag and waypoints.frame else None
        return held.plans([[plan]]) if held else Plans([[plan]])
    if bag is None:
        raise ParameterError([f"--path '{path}': is no file, and {place} is no bag with such a topic; name a file of "
                              f"waypoints, or '{REFERENCE}'"])
    held = _Recorded(run, bag, path, namespace, topics, '')
    if not held.read:
        paths = ', '.join(name for name, kind in held.topics.items() if kind == _PATH) or 'none'
        raise ParameterError([f'--path {path}: {place} has no path on that topic; topics of type {_PATH} there: '
                              f"{paths}; name one of them, a file of waypoints, or '{REFERENCE}'"])
    return held.plans(_by_goal(held.read))


def _driven_reference(run: Run) -> GoalPlan:
    """Return the way of the recorded reference, without its standstills."""
    signal = run.series.signals['reference']
    if signal.stamps.size < 2:
        raise ParameterError([f'--path {REFERENCE}: {run.name} has no recorded reference; name a topic or a file'])
    poses = signal.values[:, :3]
    moved = np.hypot(*np.diff(poses[:, :2], axis=0).T) > _MOVES
    return GoalPlan(-np.inf, '', poses[np.concatenate([[True], moved])])


def _by_goal(plans: Sequence[GoalPlan]) -> list[list[GoalPlan]]:
    """Divide plans where one ends elsewhere than the one before."""
    goals: list[list[GoalPlan]] = []
    for plan in plans:
        if goals and np.hypot(*(plan.poses[-1] - goals[-1][-1].poses[-1])[:2]) <= _SAME_GOAL:
            goals[-1].append(plan)
        else:
            goals.append([plan])
    return goals


class _Recorded:
    """What a bag has beside the topics of the loop: plans, and the transforms to their frame."""

    def __init__(self, run: Run, bag: Path, topic: str, namespace: str, topics: Mapping[str, str], frame: str) -> None:
        self._odom = run.series.signals['odom']
        self._origin = run.series.origin
        self._files = BagFiles(bag, lambda *_: None)
        prefix = f'{namespace.rstrip("/")}/'
        path, odom = (name if name.startswith('/') else prefix + name for name in (topic, topics.get('odom', 'odom')))
        self.read: list[GoalPlan] = []
        self._frame, self._odometry, self._transforms = frame, '', list[tuple[bool, Message]]()
        for message in self._files.messages(lambda name: name in (path, odom, *_TF)):
            if message.topic in _TF:
                self._transforms.append((message.topic == _TF[1], message))
            elif message.topic == path and message.kind == _PATH:
                self._take_plan(message)
            elif message.topic == odom and message.kind == _ODOMETRY and not self._odometry:
                self._odometry = deserialise(_ODOMETRY, message.data).header.frame_id.lstrip('/')
        self.topics = self._files.topics

    def _take_plan(self, message: Message) -> None:
        try:
            content = read_or_refuse(_PATH, (partial(deserialise, _PATH),), message.data)
            poses = np.array(read_path(content), float).reshape(-1, 3)
        except RefusedMessageError as refusal:
            raise ParameterError([f'{message.topic}: a plan is refused: {shortened(str(refusal))}']) from None
        if len(poses) < 2:
            return
        if not poses[:, 2].any():
            # nobody set an orientation
            poses[:, 2] = np.nan
        self._frame = self._frame or content.header.frame_id.lstrip('/')
        self.read.append(GoalPlan(self._time(serialised_stamp(message.data), message.received),
                              content.header.frame_id.lstrip('/'), poses))

    def _time(self, stamp: int, received: int) -> float:
        """Return the time of a message on the clock of odometry [s]; by its receipt where its stamp is of another."""
        stamps = self._odom.stamps
        if not (stamps[0] - _LATE * 1e9 <= stamp <= stamps[-1] + _LATE * 1e9) and self._odom.received.size:
            stamp = int(np.interp(received, self._odom.received, stamps))
        return (stamp - self._origin) / 1e9

    def plans(self, goals: list[list[GoalPlan]]) -> Plans:
        """Return plans with the corrections of odometry to their frame."""
        if self._frame in ('', self._odometry) or not self._odometry:
            return Plans(goals, self._odometry)
        frames, corrections = Frames(self._frame, self._odometry), list[tuple[float, Pose]]()
        for static, message in self._transforms:
            try:
                links = read_transforms(deserialise(message.kind, message.data))
                leads = frames.take_transforms(links, static)
            except (RefusedMessageError, ValueError, KeyError):
                # a transform of another robot, or a second publisher's: the others are used
                continue
            if leads and (correction := frames.correction()):
                stamp, pose = correction
                corrections.append((self._time(stamp or message.received, message.received), pose))
        return Plans(goals, self._odometry, corrections, frames.missing_transform())
