"""
The course of a replay: the run holds for each change, and resumes after it.

A change with a first affected stamp s > 0 is applied while the run holds at the last position tick before s, after
every node has stepped there; a reset is called at its run's last stamp. Changes from 0 on are set while the previous
run holds at its end.
"""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.node import Node
from rclpy.task import Future

from mobile_robot_control.experiment.replay_plan import Replay, changed_parameters
from mobile_robot_control.experiment.result import RunFailedError
from mobile_robot_control.experiment.runner import ExperimentRunner
from mobile_robot_control.quantities import Push
from mobile_robot_control.recording.changes import Change
from mobile_robot_control.ros.nodes.recorder import NO_LIMIT
from mobile_robot_control.ros.nodes.replayer import Replayer
from mobile_robot_control.topics import DISTURBANCE, PATH_TOPIC


class _RunIsOverError(Exception):
    """The run has ended before the replay has."""


class ReplayRun:
    """
    Leads a run, paused at its start, through a replay.

    Parameters
    ----------
    replay : Replay
        The plan.

    """

    def __init__(self, replay: Replay) -> None:
        self._replay = replay
        self._runner: ExperimentRunner
        self._replayer: Replayer

    def attach(self, namespace: str) -> Node:
        """Return the node that applies the changes."""
        changes = self._replay.changes
        self._replayer = Replayer(namespace, {change.node for change in changes if changed_parameters(change)},
                                  self._replay.configuration.plant.shared,
                                  {key for change in changes for key in change.values})
        return self._replayer

    def follow(self, runner: ExperimentRunner) -> None:
        """
        Apply all changes, up to the last one, where the run stays held; return at the end of the run.

        Raises RunFailedError if a node refuses a change.
        """
        self._runner = runner
        applied = 0
        with suppress(_RunIsOverError):
            self._wait(self._replayer.is_ready, 'the services of the nodes were not discovered')
            for run in self._replay.runs:
                for hold, changes in run.holds.items():
                    self._go_to(hold)
                    for change in changes:
                        self._apply(change)
                        applied += 1
                if run.reset_at is not None:
                    self._go_to(run.reset_at)
                    self._begin_anew()
        runner.recorder.limit = NO_LIMIT
        left = len(self._replay.changes) - applied
        if left and runner.is_over() and runner.result().outcome == 'completed':
            raise RunFailedError(f'the run was over before {left} of its changes could be done again')

    def _go_to(self, stamp: int) -> None:
        """Let the run advance until it is held at a stamp [ns] and every node has answered it."""
        if not self._runner.is_at(stamp):
            self._runner.recorder.limit = stamp
            self._runner.resume()
            self._runner.watch(lambda: self._runner.is_at(stamp))
        if not self._runner.is_at(stamp):
            raise _RunIsOverError

    def _apply(self, change: Change) -> None:
        values = changed_parameters(change)
        if values:
            answer = self._answer(self._replayer.set(change.node, values), f'{change.node} did not take {values}')
            result = answer.result
            if not result.successful:
                raise RunFailedError(f'{change.node} refuses {values}: {result.reason}')
        if DISTURBANCE in change.values:
            self._replayer.push(change.stamp, Push(*change.values[DISTURBANCE]))
            self._wait(self._replayer.have_arrived, f'the plant did not take the push of {change.stamp} ns')
        if PATH_TOPIC in change.values:
            self._replayer.lead(change.stamp, change.values[PATH_TOPIC])
            self._wait(self._replayer.have_arrived, f'the cart did not take the path of {change.stamp} ns')

    def _begin_anew(self) -> None:
        """Begin a new run, held at 0."""
        self._answer(self._runner.recorder.pause(), 'the plant did not pause')
        self._answer(self._replayer.reset(), 'the plant did not answer reset')
        self._wait(lambda: self._runner.is_at(0), 'no new run began')

    def _answer(self, asked: Future[Any], failure: str) -> Any:
        self._wait(asked.done, failure)
        return asked.result()

    def _wait(self, condition: Callable[[], Any], failure: str) -> None:
        if not self._runner.spin_until(condition, self._runner.patience):
            if self._runner.is_over():
                raise _RunIsOverError
            raise RunFailedError(f'{failure} within {self._runner.patience} s')
