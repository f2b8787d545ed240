"""The drives of a run, one for each goal, judged by their path for each pose that is known."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Annotated, NamedTuple

import numpy as np

from mobile_robot_control.drives.drive_metrics import DriveMetrics, DrivenMotion, Places, drive_metrics, places_on
from mobile_robot_control.drives.plans import REFERENCE, GoalPlan, Plans, plans_of
from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.model.robot import half_separation
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.localisation import composed
from mobile_robot_control.runs.run import Run
from mobile_robot_control.topics import GROUND_TRUTH

TRUE, LOCALISED, MEASURED = 'true', 'localisation', 'odometry'
"""Whose poses are judged: the true ones, as the localisation saw them, or those of odometry."""
FIRST, NEWEST = 'first', 'newest'


class PathChoice(NamedTuple):
    """The path that drives are judged by."""

    path: Annotated[str | None, Field('', 'also judge the drive by its path, without a reference in time: a topic of '
                                      f'plans in the bag, a file of waypoints, or {REFERENCE}')] = None
    plan: Annotated[str, Field('', 'of several plans for one goal, the first, or at any time the newest',
                               choices=(FIRST, NEWEST))] = FIRST


NO_PATH = PathChoice()


class JudgedDrive(NamedTuple):
    """
    A drive that was judged by its path.

    Attributes
    ----------
    name : str
        Of its run; with a number where that has several goals.
    kind : str
        Whose poses: TRUE, LOCALISED or MEASURED.
    path : array of float, shape (m, 3)
        x, y [m] and heading [rad] of the last plan.
    motion : DrivenMotion
        In the frame of the path.
    places : Places
        Of the motion on its plan, or on its plans in turn.
    metrics : DriveMetrics
        Of the drive.
    """

    name: str
    kind: str
    path: Floats
    motion: DrivenMotion
    places: Places
    metrics: DriveMetrics


def judged_drives(
    run: Run, place: Path, choice: PathChoice, namespace: str, topics: Mapping[str, str]
) -> tuple[list[JudgedDrive], list[str]]:
    """
    Judge the drives of a run by its path.

    Returns
    -------
    tuple of list of JudgedDrive, and list of str
        A drive for each goal and each kind of poses, and what their numbers do not tell, in words.

    Raises
    ------
    ParameterError
        If there is no path, or no pose in its frame.
    """
    assert choice.path is not None  # noqa: S101 (for mypy: asked for)
    plans = plans_of(run, place, choice.path, namespace, topics)
    motions = dict(_motions(run, plans))
    if not motions:
        raise ParameterError([f'{place}: ' + (
            f"the path is in the frame '{plans.goals[0][0].frame}', odometry in '{plans.odometry}', and "
            f'{plans.missing}; record /tf and /tf_static' if plans.missing else
            'has no odometry; name its topic with --topic odom:=/NAME')])
    drives, notes = [], []
    for number, goal in enumerate(plans.goals, 1):
        end = plans.goals[number][0].begin if number < len(plans.goals) else math.inf
        used = goal if choice.plan == NEWEST else goal[:1]
        for kind, motion in motions.items():
            part = motion.within(used[0].begin, end)
            if part.time.size < 2:
                notes.append(f'goal {number}: the recording has no motion after its plan')
                break
            name = run.name if len(plans.goals) == 1 else f'{run.name} {number}'
            drives.append(_judged(name, kind, used, part, run))
        if choice.plan == NEWEST and len(used) > 1 and drives:
            notes.append(_reset(used, drives[-1].motion))
    notes += [f'{drive.name}: over {100.0 * drive.metrics.ambiguous:.0f} % of the drive another part of the path is '
              f'nearer by 1 cm or more: at a crossing it is the order that tells, elsewhere the robot has left it'
              for drive in drives if drive.metrics.ambiguous]
    if not drives:
        raise ParameterError([f'{place}: {notes[0]}; name another topic with --path'])
    return drives, list(dict.fromkeys(notes))


def _motions(run: Run, plans: Plans) -> Iterator[tuple[str, DrivenMotion]]:
    """Yield the kinds of poses that are known in the frame of the path, the best one first, each with its motion."""
    for topic, kind in ((GROUND_TRUTH, TRUE), ('odom', MEASURED)):
        signal = run.series.signals[topic]
        if not signal.stamps.size:
            continue
        motion = DrivenMotion(run.series.time(topic), signal.values[:, :3], signal.values[:, 3:5])
        if plans.corrections:
            if topic == 'odom':
                yield LOCALISED, _corrected(motion, plans.corrections)
        elif not plans.missing:
            yield kind, motion


def _corrected(motion: DrivenMotion, corrections: Sequence[tuple[float, Pose]]) -> DrivenMotion:
    """Return a motion in the frame of the path: with each pose the last correction up to its time, or the first."""
    times = np.array([time for time, _ in corrections])
    places = np.maximum(np.searchsorted(times, motion.time, side='right') - 1, 0).tolist()
    poses = [composed(corrections[place][1], Pose(*pose))
             for place, pose in zip(places, motion.pose.tolist(), strict=True)]
    return motion._replace(pose=np.array(poses, float))


def _judged(name: str, kind: str, plans: Sequence[GoalPlan], motion: DrivenMotion, run: Run) -> JudgedDrive:
    begin = plans[0].begin if math.isfinite(plans[0].begin) else float(motion.time[0])
    own = motion._replace(time=motion.time - begin)
    ends = [*(plan.begin - begin for plan in plans[1:]), math.inf]
    begins = [-math.inf, *ends[:-1]]
    parts = [(plan.poses, own.within(start, np.nextafter(end, -math.inf)))
             for plan, start, end in zip(plans, begins, ends, strict=True)]
    on_plans = [places_on(path, part) for path, part in parts if part.time.size]
    places = Places(np.concatenate([one.along for one in on_plans]), np.concatenate([one.away for one in on_plans]),
                    max(one.ambiguous for one in on_plans))
    half = half_separation(run.parameters.plant.shared.robot) if run.parameters else math.nan
    times, commands = run.series.time('cmd_vel') - begin, run.series.signals['cmd_vel'].values[:, :2]
    told = commands[(times >= own.time[0]) & (times <= own.time[-1])]
    metrics = drive_metrics(plans[-1].poses, own, places, told, half)
    if len(plans) > 1:
        metrics = metrics._replace(progress=math.nan)
    return JudgedDrive(name, kind, plans[-1].poses, own, places, metrics)


def _reset(plans: Sequence[GoalPlan], motion: DrivenMotion) -> str:
    """Return what newer plans do to the error, in words."""
    apart = []
    for plan in plans[1:]:
        at = int(np.clip(np.searchsorted(motion.time, plan.begin - plans[0].begin), 0, motion.time.size - 1))
        apart.append(math.dist(motion.pose[at, :2].tolist(), plan.poses[0, :2].tolist()))
    return (f'{len(plans)} plans in turn: a plan that begins at the robot resets the cross-track error; these begin '
            f'{100.0 * median(apart):.3g} cm from it (median)')
