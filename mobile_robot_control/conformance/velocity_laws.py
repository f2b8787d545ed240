"""The checks of a velocity law: of single steps, of its loop, and of runs."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from random import Random
from typing import NamedTuple

from mobile_robot_control.conformance.checks import (
    Check,
    Conformance,
    LeftOutError,
    equal_over_dds,
    file_option,
    holding,
    refused,
    run_checks,
    with_dds,
)
from mobile_robot_control.conformance.sampling import bits_of
from mobile_robot_control.control import laws
from mobile_robot_control.control.velocity_law import VelocityInputs, VelocityLaw, is_finite
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.control.velocity_stability import instability_of
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.trial import Outcome, make_trial
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.registry import PluginError
from mobile_robot_control.quantities import NO_ACCELERATION, UNKNOWN_TORQUE, BodyAcceleration, BodyVelocity, WheelTorque
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import NODES, Configuration

_RATE = 500.0
"""[Hz]"""
_DURATION = 2.0
"""[s] of a run."""
_LIMIT = 0.5
"""[N m]"""


class _Case(NamedTuple):
    """An input of a step, and the limit of the torques [N m]."""

    inputs: VelocityInputs
    limit: float


def _cases() -> Iterator[_Case]:
    """Yield drawn inputs, some of them large, with every choice of feedforward, applied torque and limit."""
    draws = Random(74)  # noqa: S311 (no secret)
    for n in range(400):
        size = 100.0 if n % 40 == 39 else 1.0
        command, measured = (BodyVelocity(size * draws.gauss(0.0, 0.5), size * draws.gauss(0.0, 1.5)) for _ in range(2))
        fed = BodyAcceleration(draws.gauss(0.0, 1.0), draws.gauss(0.0, 3.0)) if n % 2 else NO_ACCELERATION
        applied = WheelTorque(draws.gauss(0.0, 0.3), draws.gauss(0.0, 0.3)) if n % 4 < 2 else UNKNOWN_TORQUE
        yield _Case(VelocityInputs(command, fed, measured, applied), _LIMIT if n % 3 else 0.0)


def _steps(law: VelocityLaw) -> Iterator[tuple[_Case, WheelTorque]]:
    """Yield the cases with the torques of a law that takes them one after the other."""
    state, gains = law.start, law.gains()
    for case in _cases():
        step = law.fed if law.fed is not None and case.inputs.acceleration != NO_ACCELERATION else law.step
        state, torque = step(state, case.inputs, gains, Robot(), case.limit, 1.0 / _RATE)
        yield case, torque


def _pure(law: VelocityLaw) -> Iterator[str]:
    for (case, first), (_, again) in zip(list(_steps(law)), _steps(law), strict=True):
        if bits_of(first) != bits_of(again):
            yield f'returns {first}, and {again} when it is run again, at {case}; keep what changes in the state'


def _finite(law: VelocityLaw) -> Iterator[str]:
    for case, torque in _steps(law):
        if not is_finite(torque):
            yield f'returns {torque} at {case}'


def _within_limit(law: VelocityLaw) -> Iterator[str]:
    for case, torque in _steps(law):
        if case.limit > 0.0 and max(map(abs, torque)) > case.limit:
            yield f'returns {torque} at {case}; saturate the torque at its limit'


def _stable(law: VelocityLaw) -> Iterator[str]:
    for lockstep in (True, False):
        fault = instability_of(law, law.gains(), Robot(), 0.0, _RATE, lockstep)
        if fault:
            yield fault


def _configuration(law: VelocityLaw, feeds: bool) -> Configuration:
    shared: dict[str, object] = {'feedforward.enabled': feeds, 'reference_horizon': int(feeds)}
    own: dict[str, dict[str, object]] = {
        'velocity_controller': {'controller_type': law.name, 'max_wheel_torque': _LIMIT},
        'plant': {'initial_pose': (0.9, 0.1, 1.0)}}
    return configure({node: {**shared, **own.get(node, {})} for node in NODES})


def _outcome(law: VelocityLaw, feeds: bool, compiled: bool) -> Outcome:
    trial = make_trial(_configuration(law, feeds), _DURATION)
    return batch.run_trials([trial], compiled)[0]


def _runs(law: VelocityLaw) -> Iterator[str]:
    for feeds in (False, True):
        outcome = _outcome(law, feeds, compiled=False)
        if outcome.law_failed or outcome.steps != round(_DURATION * _RATE):
            yield (f'a run {"with" if feeds else "without"} feedforward ends after {outcome.steps / _RATE:g} s, '
                   f'{"with a torque that is not finite" if outcome.law_failed else "since the motion diverges"}')


def _compiled(law: VelocityLaw) -> Iterator[str]:
    if not batch.COMPILES:
        raise LeftOutError(batch.WHY_PLAIN)
    for feeds in (False, True):
        if not batch.compiles(make_trial(_configuration(law, feeds), 0.0)):
            raise LeftOutError('numba cannot compile it; the reason is told above')
        plain, compiled = (_outcome(law, feeds, form).totals for form in (False, True))
        if any(not math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in zip(plain, compiled, strict=True)):
            yield f'a run sums up to {plain} plain and to {compiled} compiled'


VELOCITY_LAW_CHECKS: dict[str, Callable[[VelocityLaw], Iterator[str]]] = {
    'pure': _pure,
    'finite': _finite,
    'limit': _within_limit,
    'stable': _stable,
    'run': _runs,
    'compiled': _compiled,
}


def _over_dds(law: VelocityLaw) -> Iterator[str]:
    yield from equal_over_dds(file_option(VELOCITY_LAWS, law, law.step, '--velocity-law'), laws.BUILT_IN[0].name,
                              next(iter(CURVES)), f'velocity_controller.controller_type:={law.name}')


def checked_velocity_law(law: VelocityLaw, over_dds: bool) -> Conformance:
    """Make all checks of a velocity law; see `testing.check_velocity_law`."""
    subject = f"the velocity law '{getattr(law, 'name', law)}'"
    with ExitStack() as held:
        try:
            held.enter_context(holding(VELOCITY_LAWS, law))
        except PluginError as error:
            refused(subject, error.violations)
        checks: dict[str, Check] = {name: partial(check, law) for name, check in VELOCITY_LAW_CHECKS.items()}
        return run_checks(subject, with_dds(checks, partial(_over_dds, law), over_dds))
