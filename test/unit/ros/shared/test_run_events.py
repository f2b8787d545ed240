"""Changes are published with the step or the run that they act from, and replaying them ends with the same values."""

import json

from helpers.watching import stamp_nanoseconds

from mobile_robot_control.ros.shared.run_events import RunEvents


class Still:
    """A node whose publisher keeps what it is given: stamp, run and changes of each message."""

    def __init__(self):
        self.published = []

    def create_publisher(self, *_):
        return self

    def get_fully_qualified_name(self):
        return '/robot1/reference_cart'

    def publish(self, array):
        assert {(status.name, status.hardware_id) for status in array.status} == {('robot1/reference_cart', 'robot1')}
        run, = {int(status.values[1].value) for status in array.status}
        self.published.append((stamp_nanoseconds(array.header.stamp), run, {
            status.values[0].key: json.loads(status.values[0].value) for status in array.status}))


def test_changes_act_from_a_step_or_from_a_run_on_and_the_first_run_has_the_number_0():
    node = Still()
    events = RunEvents(node)
    events.note_changes({'curve': 'circle'}, at_start=True)
    events.begin_run(anew=False, with_changes=False)
    assert not events.pending
    events.begin_run(anew=False)
    events.publish_pending(0)
    events.note_changes({'paused': True, 'hold_at': 3.0})
    assert not events.pending
    events.note_changes({'scale': 0.5, 'period': 12.0}, at_start=True)
    events.note_changes({'period': 0.1 + 0.2})
    events.publish_pending(1_500_000_000)
    events.note_changes({'period': 8.0})
    events.note_changes({'center': (1.0, 2.0)}, at_start=True)
    events.begin_run(anew=True)
    events.publish_pending(0)
    assert node.published == [
        (0, 0, {'curve': 'circle'}), (1_500_000_000, 0, {'period': 0.30000000000000004}), (0, 1, {'period': 8.0}),
        # the newest lap time, which was set after the scale
        (0, 1, {'scale': 0.5, 'period': 8.0, 'center': [1.0, 2.0]})]
    assert not events.pending
