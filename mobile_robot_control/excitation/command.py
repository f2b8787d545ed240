"""
The command `excite`: drive a robot for a recording that `identify` can use, within a box.

It sends steps, ramps, chirps and curves of both velocities on the wall clock, as the type of `cmd_vel` that
the robot subscribes to. Without --yes nothing moves: the command says what it would do.

A manoeuvre ends early where odometry shows that the robot could not stop in the box within 1 s times its
speed; the robot then drives back to the middle. A box smaller than 4 s times the largest velocity is
refused. Zero commands stop the robot at the end, on Ctrl-C, in a closed terminal, outside the box, when
another node commands it, when the bag cannot be written, and when odometry is silent for 0.5 s, has old
stamps or two publishers, stays unchanged despite the commands, or jumps. These stops need a network and a
process: keep a hand on the robot's switch. Odometry that drifts moves the box, too.

For example:
  mrc excite --box 2 2 --max-velocity 0.4 --max-angular-velocity 1.5

Exit codes:
  0  done
  1  ended early, with the reason
  2  bad usage, or no robot to drive
"""

import argparse
import sys
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_dds_main, make_parser, request_of
from mobile_robot_control.excitation.request import ExcitationRequest, area_of
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.ros.shared.process import Stop, check_environment
from mobile_robot_control.system.texts import printable


class _Consent(NamedTuple):
    """Whether the robot may move."""

    yes: Annotated[bool, Field('', 'move the robot')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `excite`."""
    # before all else: a signal is not lost
    stop = Stop()
    command = make_parser('excite', __doc__, ExcitationRequest, _Consent)
    command.set_defaults(stop=stop)
    return command


def _run(options: argparse.Namespace) -> int:
    request = request_of(ExcitationRequest, options)
    area = area_of(request)
    request.sources.configuration(request.namespace)  # odd parameters are refused before the floor is cleared
    if not request_of(_Consent, options).yes:
        print(f'would drive for {request.duration:g} s with up to {area.fastest.linear:g} m/s and '
              f'{area.fastest.angular:g} rad/s, within {0.5 * area.ahead:g} m ahead and behind, and '
              f'{0.5 * area.aside:g} m to both sides; clear that floor, keep a hand on the switch, and repeat with '
              '--yes')
        return 0
    check_environment()
    # imported late: the environment is checked, and nothing is needed to say what would be done
    from mobile_robot_control.excitation.driving import excite_robot  # noqa: PLC0415

    done = excite_robot(request, area, options.stop)
    print(f'driven {done.way:.2f} m, turned {done.turn:.1f} rad, at most {done.farthest:.2f} m from the start')
    if request.bag:
        print(f'bag: {printable(request.bag)}')
    if done.fault:
        print(f'excite: {printable(done.fault)}; the robot got zero commands', file=sys.stderr)
    return 1 if done.fault else 0


main = make_dds_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
