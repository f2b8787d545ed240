"""A robot on the wall clock observed from outside: position errors, and when a quantity became zero."""

import math

from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.ros.shared.qos import PUBLISHED


def stamp_nanoseconds(stamp):
    """Return a message's stamp (builtin_interfaces/Time) [ns]."""
    return stamp.sec * NANOSECONDS + stamp.nanosec


class Timeline:
    """
    Values by their stamps [s since the epoch], which do not depend on when this process takes a message in.

    `errors` [m], `speeds` of the robot, `commands` (largest component), `requested` and `applied` torques [N m].
    """

    def __init__(self, node):
        self.errors, self.speeds, self.commands, self.requested, self.applied = [], [], [], [], []
        for topic, kind, values, read in (
            ('tracking_error', Vector3Stamped, self.errors, lambda error: math.hypot(error.vector.x, error.vector.y)),
            ('odom', Odometry, self.speeds, lambda odom: abs(odom.twist.twist.linear.x)),
            ('cmd_vel', TwistStamped, self.commands,
             lambda command: max(abs(command.twist.linear.x), abs(command.twist.angular.z))),
            ('wheel_torques', JointState, self.requested, lambda joints: max(map(abs, joints.effort))),
            ('joint_states', JointState, self.applied, lambda joints: max(map(abs, joints.effort))),
        ):
            def take(message, values=values, read=read):
                values.append((stamp_nanoseconds(message.header.stamp) / 1e9, read(message)))

            node.create_subscription(kind, topic, take, PUBLISHED)

    def rms_error(self, since):
        """Return the RMS position error [m] from a time on."""
        late = [error for at, error in self.errors if at >= since]
        assert late
        return math.sqrt(sum(error**2 for error in late) / len(late))


def first_below(values, since, bound):
    """Return when a quantity was first not above a bound, from a time on [s]; None if never."""
    return next((at for at, value in values if at >= since and value <= bound), None)


def settled_below(values, since, bound, seconds):
    """Return from when on [s] a quantity stayed below a bound, for some seconds at least; None if it does not yet."""
    above = [at for at, value in values if at >= since and value > bound]
    begun = max([since, *above])
    return begun if values and values[-1][0] >= begun + seconds else None
