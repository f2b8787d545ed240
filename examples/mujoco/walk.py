"""
The walk of docs/own_robot.md with two robots in MuJoCo: record, identify, tune, promise, drive.

python walk.py FOLDER [WALK ...] walks in FOLDER/WALK, prints the table and writes it to FOLDER/walks.json. What a
folder has is not made again.
"""

import csv
import json
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import yaml

import mobile_robot_control as mrc

HERE = Path(__file__).parent
WALKS = tuple(f'{robot}_{level}' for level in ('velocity', 'torque') for robot in ('differential', 'skid_steer'))
CURVES = ('lemniscate', 'trifolium')
DRIVES = 4
"""The first of the drawn starts are driven."""
_SKIDS = 0.1
"""An error of the separation beyond which wheels skid in turns, and the firmware gets another one."""


class Walk:
    """One robot that takes velocities or torques, with all that the walk makes in a folder."""

    def __init__(self, folder, name):
        self.folder, (self.robot, self.level) = folder / name, name.rsplit('_', 1)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.files = [HERE / f'{self.robot}.yaml']

    def run(self, output, *words):
        """Run a command of the package that makes a file or folder, unless that is there; keep what it prints."""
        output = self.folder / output
        if not output.exists():
            files = [word for file in self.files for word in ('--params-file', file)]
            words = [str(word) for word in (*words, *files)]
            print('+ mrc', shlex.join(words), flush=True)
            done = subprocess.run([sys.executable, '-m', 'mobile_robot_control', *words], check=False, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            if done.returncode:
                sys.exit(f'{words[0]} ended with {done.returncode}:\n{done.stdout}')
            output.with_suffix('.txt').write_text(done.stdout)
        return output

    def record(self, name):
        """Excite the robot for a minute on the wall clock; return the bag."""
        options = ['--ros-args', *(word for file in self.files for word in ('--params-file', file)), '-p',
                   'lockstep:=false']
        nodes = [[sys.executable, HERE / 'plant.py', self.robot, *options]]
        if self.level == 'torque':
            nodes.append([sys.executable, '-m', 'mobile_robot_control', 'velocity_controller', *options])
        running = [] if (self.folder / name).exists() else [subprocess.Popen(words) for words in nodes]
        try:
            return self.run(name, 'excite', '-p', '/**.lockstep:=false', '--box', 4, 4, '--max-velocity', 0.5,
                            '--max-angular-velocity', 1.5, '--yes', '--bag', self.folder / name)
        finally:
            for node in running:
                node.send_signal(signal.SIGINT)
            for node in running:
                node.wait(10.0)

    def identify(self, name):
        """Record and identify the robot; return the file of what shows, and the estimates in it."""
        file = self.run(f'{name}.yaml', 'identify', self.record(f'{name}_bag'), '--same-clock', '--accept', '--output',
                        self.folder / f'{name}.yaml', '--report', self.folder / f'{name}_page')
        return file, {name: value for node in yaml.safe_load(file.read_text()).values()
                      for name, value in node['ros__parameters'].items()}

    def learn(self):
        """Identify the robot; one that skids gets the separation of wheels that do not, and is identified again."""
        file, found = self.identify('first')
        error = found.get('odometry.separation_error', 0.0)
        if abs(error) > _SKIDS:
            known = yaml.safe_load(self.files[0].read_text())['/**']['ros__parameters']['robot']['wheel_separation']
            firmware = self.folder / 'firmware.yaml'
            firmware.write_text(yaml.safe_dump({'/**': {'ros__parameters': {
                'robot.wheel_separation': round(known / (1.0 + error), 3)}}}))
            self.files.append(firmware)
            file, found = self.identify('again')
        self.files.append(file)
        return found

    def tune(self, name, law, *options):
        """Search gains, and go on with their file."""
        self.files = [self.run(name, 'tune', law, '--seed', 1, '--random', 8, *options, '--output',
                               self.folder / name)]

    def promise(self, found):
        """Return the runs of 200 robots that the recording may be of; of one, if it is not told how sure it is."""
        drawn = ('--robot-uncertainty', self.learnt) if 'covariance' in found else ()
        study = self.run('study', 'study', '--runs', 200, '--seed', 1, '--laps', 1, *drawn, '--curves', *CURVES,
                         '--scales', 1, '--within', 0.2, '--output', self.folder / 'study')
        with (study / 'runs.csv').open() as file:
            return list(csv.DictReader(file))

    def drive(self, number, start):
        """Drive the robot in lockstep from a start of the study; return the RMS of its true error [m]."""
        begun = mrc.simulate(*self.files, duration=0.1, parameters={'reference_cart.curve': start['curve']})
        pose = [float(cart) + float(start[f'start_{axis}'])
                for cart, axis in zip(begun.reference[0], ('x', 'y', 'yaw'), strict=True)]
        run = self.run(
            f'drive_{number}', 'experiment', '--duration', 20, '--node',
            f'plant={shlex.join([sys.executable, str(HERE / "plant.py"), self.robot])}', '-p',
            f'plant.initial_pose:={pose}', '-p', f'reference_cart.curve:={start["curve"]}', '-p',
            'plant.real_time_factor:=0.0', '--output', self.folder / f'drive_{number}')
        return json.loads((run / 'metrics.json').read_text())['rms_position_error']

    def walk(self):
        """Take all steps; return what is promised and what is true."""
        if self.level == 'torque':
            self.files.append(HERE / 'torques.yaml')
            self.tune('first_gains.yaml', 'velocity', '--delays', 1, 2, '--coulomb', 0, 0.05)
        found = self.learn()
        self.learnt = self.files[-1]
        if self.level == 'torque':
            self.tune('velocity_gains.yaml', 'velocity', '--delays', 1, 2, '--coulomb', 0, 0.05)
        self.tune('gains.yaml', 'backstepping', '--delays', 0, 2)
        runs = self.promise(found)
        drives = []
        for number, start in enumerate(runs[:DRIVES]):
            errors = [float(run['rms_position_error']) for run in runs if run['curve'] == start['curve']]
            low, high = np.quantile(errors, (0.025, 0.975)).tolist()
            drives.append({'curve': start['curve'], 'true': self.drive(number, start), 'promised': [low, high]})
        return {'robot': self.robot, 'level': self.level, 'grade': found.get('grade', 'unusable'), 'drives': drives}


def table(walks):
    """Return the table of walks as Markdown; errors in cm."""
    rows = ['| robot | takes | model | promised | true | within |', '|---|---|---|---|---|---|']
    for walk in walks:
        for curve in CURVES:
            drives = [one for one in walk['drives'] if one['curve'] == curve]
            if drives:
                low, high = drives[0]['promised']
                errors = [one['true'] for one in drives]
                within = sum(low <= error <= high for error in errors)
                words = ', '.join(f'{100.0 * error:.2g}' for error in errors)
                rows.append(f'| {walk["robot"]}, {curve} | {walk["level"]} | {walk["grade"]} | {100.0 * low:.2g} to '
                            f'{100.0 * high:.2g} cm | {words} cm | {within} of {len(drives)} |')
    return '\n'.join(rows)


def main(folder, *names):
    """Walk, and show the table."""
    began = time.monotonic()
    walks = [Walk(Path(folder).absolute(), name).walk() for name in names or WALKS]
    (Path(folder) / 'walks.json').write_text(json.dumps(walks, indent=1))
    print(table(walks), f'\n{time.monotonic() - began:.0f} s')


if __name__ == '__main__':
    if len(sys.argv) < 2 or set(sys.argv[2:]) - {*WALKS}:
        sys.exit(f'name a folder, and walks of {", ".join(WALKS)}')
    main(*sys.argv[1:])
