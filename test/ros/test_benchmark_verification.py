"""Runs of a benchmark, done again by four nodes over DDS."""

import json
import subprocess
import sys

from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking.cell_result import read_result, write_result
from mobile_robot_control.loop import batch

TRACKS = {
    'pushed': """
track: {ros__parameters: {purpose: Torques and noise., curves: [trifolium], scales: [0.1], turned: 1.0, laps: 0.25,
    variation: 0.2, delays: [1, 2]}}
/**: {ros__parameters: {reference_horizon: 1, velocity_rate: 200.0, position_rate: 50.0}}
/**/plant: {ros__parameters: {max_wheel_torque: 3.0, noise: {pose: [0.001, 0.001, 0.001], velocity: 0.01}}}
/**/velocity_controller: {ros__parameters: {max_wheel_torque: 3.0, controller_type: computed_torque}}
/**/reference_cart: {ros__parameters: {curve: trifolium, scale: 0.1, period: 4.0}}
""",
    'late': """
track: {ros__parameters: {purpose: A base with lag and odometry that drifts., robot: kobuki, scales: [0.2], laps: 0.03,
    within: 0.05, variation: 0.3}}
/**: {ros__parameters: {reference_horizon: 1}}
""",
}
MAIN = ('import sys; from mobile_robot_control.benchmarking import command; '
        'from mobile_robot_control.loop import batch; '
        'batch.COMPILES = False; command._DRAWN = {}; sys.exit(command.main())')


def test_drawn_runs_are_the_same_over_dds_and_one_that_is_not_is_told(domain, tmp_path, monkeypatch):
    # gains as configured
    arguments = ['--laws', 'ramsete', 'hybrid_backstepping', '--no-tune', '--feedforward', '--runs', '3',
                 '--workers', '1', '--output', str(tmp_path / 'out'), '--tracks']
    for name, text in TRACKS.items():
        (tmp_path / f'{name}.yaml').write_text(text)
        arguments.append(str(tmp_path / f'{name}.yaml'))
    monkeypatch.setattr(batch, 'COMPILES', False)
    assert benchmark.main(arguments) == 0

    def verify(drawn):
        # nodes leave DDS with their process
        return subprocess.run([sys.executable, '-c', MAIN.format(drawn), *arguments, '--verify'], capture_output=True,
                              text=True, timeout=200, check=False)

    verified = verify(2)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert verified.stdout.count('the same within 1e-09') == 2
    assert [one['difference'] for one in json.loads((tmp_path / 'out' / 'verified.json').read_text())] == [''] * 2
    # gains that are not those of the table
    for file in (tmp_path / 'out' / 'cells').glob('*.json'):
        cell = read_result(file)
        for name, value in cell.results[0].gains.items():
            cell.results[0].gains[name] = value * (1.0 + 1e-3) if isinstance(value, float) else value
        write_result(file, cell)
    changed = verify(1)
    assert changed.returncode == 1
    assert 'in the table' in changed.stderr
