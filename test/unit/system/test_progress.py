"""Progress bars that name their waits."""

import io

from mobile_robot_control.system.progress import StagedBar


def test_a_bar_says_what_is_done_before_its_first_update_and_after_its_last():
    shown = io.StringIO()
    with StagedBar(2, 'run', 'driving', True, file=shown, mininterval=0.0) as bar:
        assert 'compiling:   0%' in shown.getvalue()
        bar.update()
        assert 'driving:  50%' in shown.getvalue()
        bar.update()
    assert shown.getvalue().splitlines()[-1].startswith('analysing and drawing: 100%')
