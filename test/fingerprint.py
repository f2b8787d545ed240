"""
Print one checksum for each output that a change of the code's structure must leave as it is, byte for byte.

``make fingerprint`` runs the commands that this checkout installs. To compare two checkouts::

    diff <(make -s -C OLD fingerprint) <(make -s -C NEW fingerprint)

Covered: the CSV and JSON of `simulate` for every shipped parameter file and for the options of the plant, the files of
`tune` and `study` with a seed, the messages on the loop's topics in lockstep bags with the metrics and the report of
each, and a run as Python has it: simulated, and read from a CSV file and from a bag.
"""

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from mcap.reader import make_reader

import mobile_robot_control as mrc

CONFIG = Path(__file__).resolve().parents[1] / 'config'
LOOP = ('joint_states', 'wheel_torques', 'odom', 'reference', 'cmd_vel', 'tracking_error')
PLANT = {
    'noise': ['plant.noise.pose:=[0.01, 0.02, 0.005]', 'plant.noise.velocity:=0.05', 'plant.noise.seed:=7'],
    'delay': ['plant.delay.velocity_steps:=2'],
    'disturbance': ['plant.disturbance.time:=1.0', 'plant.disturbance.impulse:=[0.002, -0.001]',
                    'plant.disturbance.step:=[0.05, 0.02]'],
    'coupling': ['plant.centripetal_coupling:=true'],
    'limits': ['plant.max_wheel_torque:=0.5', 'velocity_controller.max_wheel_torque:=0.6',
               'position_controller.limits.linear_velocity:=0.4',
               'position_controller.limits.angular_acceleration:=2.0'],
}
SEARCHES = [('velocity', 'genetic', []), ('backstepping', 'genetic', ['--mass', '0.8', '1.2']),
            ('hybrid_backstepping', 'genetic', ['--start=-0.2,0,0']), ('fuzzy', 'genetic', []),
            ('fuzzy', 'differential_evolution', ['--with-velocity', '--random', '2'])]


def _run(name, *arguments, folder):
    """Run an installed command of the package; returns what it prints."""
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control', name, *map(str, arguments)], cwd=folder,
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def _overrides(texts):
    return [word for text in texts for word in ('-p', text)]


def _numbers(path):
    """Return the content of a JSON file without what it was made with."""
    def kept(found):
        return {name: value for name, value in found.items() if name != 'provenance'}

    return json.dumps(json.loads(path.read_text(), object_hook=kept), indent=2).encode() + b'\n'


def _report(name, content):
    print(f'{hashlib.sha256(content).hexdigest()[:32]}  {name}', flush=True)


def _simulations(folder):
    cases = {str(file.relative_to(CONFIG)): ['--params-file', file] for file in sorted(CONFIG.rglob('*.yaml'))
             if file.parent.name != 'lessons'}  # these are for the live page
    cases |= {f'with {name}': _overrides(texts) for name, texts in PLANT.items()}
    cases['with all'] = _overrides(text for texts in PLANT.values() for text in texts)
    for name, arguments in cases.items():
        printed = _run('simulate', '--duration', 4, *arguments, '--output', 'run.csv', '--json', folder=folder)
        _report(f'simulate {name}: JSON', printed)
        _report(f'simulate {name}: CSV', (folder / 'run.csv').read_bytes())


def _searches(folder):
    for controller, algorithm, options in SEARCHES:
        name = f'{controller}_{algorithm}'
        _run('tune', controller, '--seed', 1, '--generations', 4, '--algorithm', algorithm, '--population', 12,
             '--output', f'{name}.yaml', *options, folder=folder)
        for ending in ('yaml', 'csv'):
            _report(f'tune {name}.{ending}', (folder / f'{name}.{ending}').read_bytes())


def _studies(folder):
    files = [CONFIG / f'{law}.yaml' for law in ('backstepping', 'hybrid_backstepping', 'fuzzy')]
    _run('study', '--runs', 30, '--seed', 1, '--output', 'study', '--compare', *files, '--noise-velocity', 0.02,
         '--longest-delay', 2, '-p', 'plant.max_wheel_torque:=3.0', folder=folder)
    _report('study runs.csv', (folder / 'study' / 'runs.csv').read_bytes())
    _report('study study.json', _numbers(folder / 'study' / 'study.json'))


def _bags(folder):
    for name, arguments in (
        *((law, ['--params-file', CONFIG / f'{law}.yaml']) for law in ('backstepping', 'hybrid_backstepping', 'fuzzy')),
        ('all options', _overrides(text for texts in PLANT.values() for text in texts)),
    ):
        output = folder / name.replace(' ', '_')
        _run('experiment', '--duration', 2, '--output', output, '--composed', '-p',
             'plant.real_time_factor:=0.0', *arguments, folder=folder)
        for file in ('metrics', 'report'):
            _report(f'bag {name}: {file}.json', _numbers(output / f'{file}.json'))
        with (output / 'bag' / 'bag.mcap').open('rb') as file:
            # a repeated message is the same, and counts once
            recorded = {(channel.topic, message.data) for _, channel, message in make_reader(file).iter_messages()
                    if channel.topic.strip('/') in LOOP}
        for topic in LOOP:
            messages = sorted(data for name_, data in recorded if name_ == f'/{topic}')
            if messages:
                _report(f'bag {name}: {len(messages)} messages on {topic}', b''.join(messages))


def _run_in_python(folder):
    file = CONFIG / 'backstepping.yaml'
    simulated = mrc.simulate(file, duration=2.0, parameters={'plant.noise.velocity': 0.05})
    simulated.save(folder / 'python.csv')
    _run('experiment', '--duration', 2, '--output', 'python', '--composed', '--no-report', '-p',
         'plant.real_time_factor:=0.0', '--params-file', file, '-p', 'plant.noise.velocity:=0.05',
         folder=folder)
    for name, run in (('simulated', simulated), ('read from a CSV file', mrc.load(folder / 'python.csv')),
                      ('read from a bag', mrc.load(folder / 'python'))):
        for column, values in run.columns().items():
            _report(f'run {name}: {column}', values.tobytes())
        _report(f'run {name}: metrics', json.dumps(run.metrics).encode())


if __name__ == '__main__':
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 230 + 1))
    with tempfile.TemporaryDirectory() as place:
        for part in (_simulations, _searches, _studies, _bags, _run_in_python):
            part(Path(place))
