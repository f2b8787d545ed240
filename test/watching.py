"""What a robot on the wall clock does, as seen from outside: position errors, and when a quantity became zero."""

import math

from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from mobile_robot_control.messages.parsing import stamp_nanoseconds
from mobile_robot_control.ros.qos import SUBSCRIBED


class Timeline:
    """
    Values by their stamps [s since the epoch]: a listener that is held up does not make a robot late.

    `errors` [m], `speeds` of the robot, `commands` (largest component), `asked` and `applied` torques [N m].
    """

    def __init__(self, node):
        self.errors, self.speeds, self.commands, self.asked, self.applied = [], [], [], [], []
        for topic, kind, values, read in (
            ('tracking_error', Vector3Stamped, self.errors, lambda said: math.hypot(said.vector.x, said.vector.y)),
            ('odom', Odometry, self.speeds, lambda said: abs(said.twist.twist.linear.x)),
            ('cmd_vel', TwistStamped, self.commands,
             lambda said: max(abs(said.twist.linear.x), abs(said.twist.angular.z))),
            ('wheel_torques', JointState, self.asked, lambda said: max(map(abs, said.effort))),
            ('joint_states', JointState, self.applied, lambda said: max(map(abs, said.effort))),
        ):
            def take(message, values=values, read=read):
                values.append((stamp_nanoseconds(message.header.stamp) / 1e9, read(message)))

            node.create_subscription(kind, topic, take, SUBSCRIBED)

    def rms_error(self, since):
        """RMS position error [m] since a time."""
        late = [error for at, error in self.errors if at >= since]
        assert late
        return math.sqrt(sum(error**2 for error in late) / len(late))


def first_below(values, since, bound):
    """When a quantity was first not above a bound since a time [s]; None if never."""
    return next((at for at, value in values if at >= since and value <= bound), None)


def settled_below(values, since, bound, seconds):
    """When a quantity was first below a bound for good, which must have lasted some time; None if not yet."""
    above = [at for at, value in values if at >= since and value > bound]
    begun = max([since, *above])
    return begun if values and values[-1][0] >= begun + seconds else None
