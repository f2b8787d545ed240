"""Drives on the page of a report: repetitions as groups."""

import json

import mobile_robot_control as mrc
from mobile_robot_control.report import command as report


def test_repetitions_are_compared_as_groups_and_single_drives_side_by_side(tmp_path, quick):
    for name, gain in (('a1', 1.0), ('a2', 1.2), ('b1', 4.0), ('b2', 4.4)):
        mrc.simulate(duration=1.0, parameters={'position_controller.backstepping.p': gain, 'plant.initial_pose': [
            1.0, 0.05, 1.5]}).save(tmp_path / f'{name}.csv')
    groups = [f'{name}={tmp_path}/{letter}1.csv,{tmp_path}/{letter}2.csv'
              for name, letter in (('soft', 'a'), ('stiff', 'b'))]
    assert report.main([*groups, '--path', 'reference', '--output', str(tmp_path / 'groups')]) == 0
    page = (tmp_path / 'groups' / 'report.html').read_text()
    assert '2 drives, poses of odometry' in page
    assert 'Medians of the drives' in page
    content = json.loads((tmp_path / 'groups' / 'report.json').read_text())
    assert [len(content[name]['path']) for name in ('soft', 'stiff')] == [2, 2]
    assert report.main([str(tmp_path / 'a1.csv'), '--path', 'reference', '--output', str(tmp_path / 'one')]) == 0
    page = (tmp_path / 'one' / 'report.html').read_text()
    assert 'cross-track error, RMS' in page
    assert 'Medians of the drives' not in page


def test_a_repetition_that_cannot_be_read_is_refused_by_name(tmp_path, capsys):
    mrc.simulate(duration=0.1).save(tmp_path / 'one.csv')
    group = f'a={tmp_path}/one.csv,{tmp_path}/none.csv'
    assert report.main([group, '--path', 'reference', '--output', str(tmp_path / 'out')]) == 2
    assert 'none.csv: does not exist' in capsys.readouterr().err
