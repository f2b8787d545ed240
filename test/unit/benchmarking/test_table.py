"""The table of a benchmark."""

from mobile_robot_control.benchmarking.table import is_first


def test_a_law_that_succeeds_in_fewer_than_half_of_the_runs_is_no_first():
    assert [share for share in (0.0, 0.25, 0.49, 0.5, 1.0) if is_first({'rank': 1, 'success': share})] == [0.5, 1.0]
    assert not is_first({'rank': 2, 'success': 1.0})
