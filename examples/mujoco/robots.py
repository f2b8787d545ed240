"""Two robots in MuJoCo: bodies, contacts and friction, and firmware that sees its wheels alone."""

import math
import sys
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

STEP = 0.0005
"""Of the physics [s]."""
RAMP = (1.0, 4.0)
"""The most that the firmware changes a velocity by [m/s²], [rad/s²]."""


class Build(NamedTuple):
    """
    What a robot is made of.

    Attributes
    ----------
    radius, separation : float
        Of its wheels, and of their middles [m].
    places : tuple of float
        Of the wheels of a side, ahead of the middle [m].
    gain : float
        Of the firmware's velocity loops [N m s/rad].
    torque : float
        The most that a motor gives [N m].
    body : str
        The geoms of its body.
    """

    radius: float
    separation: float
    places: tuple[float, ...]
    gain: float
    torque: float
    body: str


BUILDS = {
    # two wheels, and a ball that slides
    'differential': Build(radius=0.075, separation=0.30, places=(0.0,), gain=0.8, torque=2.0, body="""
      <geom type="cylinder" pos="-0.05 0 0.05" size="0.14 0.05" mass="8" rgba="0.20 0.42 0.70 1"/>
      <geom type="cylinder" pos="-0.05 0 0.115" size="0.06 0.015" mass="0.4" rgba="0.15 0.15 0.17 1"/>
      <geom type="sphere" pos="-0.15 0 -0.05" size="0.025" mass="0.1" priority="1" friction="0.02"/>"""),
    # four wheels, of which those of a side turn alike
    'skid_steer': Build(radius=0.098, separation=0.376, places=(0.131, -0.131), gain=20.0, torque=6.0, body="""
      <geom type="box" pos="0 0 0.03" size="0.21 0.155 0.06" mass="16.5" rgba="0.85 0.62 0.16 1"/>
      <geom type="box" pos="0.05 0 0.105" size="0.07 0.08 0.015" mass="0.5" rgba="0.15 0.15 0.17 1"/>"""),
}
_SIDES = ('right', 'left')
_WHEEL = """
      <body pos="{ahead} {aside} 0">
        <joint name="{name}" axis="0 1 0" damping="0.01" frictionloss="0.01"/>
        <geom class="tyre" size="{radius} 0.02 {radius}"/>
        <geom class="spoke" size="{spoke} 0.012 0.021"/>
      </body>"""
_MOTORS = {
    'velocity': '<velocity joint="{name}" kv="{gain}" forcerange="-{torque} {torque}"/>',
    'torque': '<motor joint="{name}" forcerange="-{torque} {torque}"/>',
}
_WORLD = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast" cone="elliptic"/>
  <visual>
    <global offwidth="1600" offheight="900"/><quality shadowsize="4096" offsamples="8"/>
    <headlight ambient="0.45 0.45 0.45" diffuse="0.35 0.35 0.35"/><map haze="0.4"/><rgba haze="1 1 1 1"/>
  </visual>
  <default>
    <default class="tyre">
      <geom type="ellipsoid" mass="0.45" friction="0.5" rgba="0.12 0.12 0.13 1"/>
    </default>
    <default class="spoke">
      <geom type="box" euler="90 0 0" mass="0" contype="0" conaffinity="0" rgba="0.9 0.9 0.9 1"/>
    </default>
  </default>
  <asset>
    <texture type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="64" height="384"/>
    <texture name="floor" type="2d" builtin="checker" rgb1="0.88 0.89 0.90" rgb2="0.80 0.82 0.84" width="64"
             height="64"/>
    <material name="floor" texture="floor" texrepeat="20 20"/>
  </asset>
  <worldbody>
    <light pos="-1 -2 4" dir="0.2 0.4 -1" diffuse="0.45 0.45 0.45"/>
    <geom type="plane" size="10 10 0.1" material="floor" friction="0.5"/>
    <body name="base" pos="{x} {y} {radius}" euler="0 0 {degrees}"><freejoint/>{body}{wheels}
    </body>
  </worldbody>
  <equality>{belts}</equality>
  <actuator>{motors}</actuator>
</mujoco>"""


def world(name: str, drive: str, pose: Sequence[float] = (0.0, 0.0, 0.0)) -> str:
    """Return the MJCF of a robot at x, y [m] and a heading [rad]; its motors take 'velocity' or 'torque'."""
    build = BUILDS[name]
    joints = [(f'{side}_{number}', ahead, aside) for side, aside in zip(_SIDES, (-0.5, 0.5), strict=True)
              for number, ahead in enumerate(build.places)]
    wheels = ''.join(_WHEEL.format(name=joint, ahead=ahead, aside=aside * build.separation, radius=build.radius,
                                   spoke=0.75 * build.radius) for joint, ahead, aside in joints)
    motors = ''.join(_MOTORS[drive].format(name=joint, gain=build.gain, torque=build.torque) for joint, _, _ in joints)
    # the wheels of a side turn alike
    belts = ''.join(f'<joint joint1="{side}_0" joint2="{side}_1"/>' for side in _SIDES if len(build.places) > 1)
    return _WORLD.format(step=STEP, x=pose[0], y=pose[1], degrees=math.degrees(pose[2]), radius=build.radius,
                         body=build.body, wheels=wheels, belts=belts, motors=motors)


class Robot:
    """
    A robot in its world, at rest at its pose.

    Parameters
    ----------
    name : str
        Of a build.
    drive : str
        What its motors take: 'velocity' or 'torque'.
    pose : tuple of float
        x, y [m], heading [rad] of the middle of its wheels.
    radius, separation : float
        Of its wheels, as its firmware takes them [m].

    Attributes
    ----------
    odometry : tuple of float
        x, y [m], heading [rad] by the wheels, as if none slipped.
    """

    def __init__(self, name: str, drive: str, pose: Sequence[float], radius: float, separation: float) -> None:
        self._wheels, self._radius, self._separation = len(BUILDS[name].places), radius, separation
        self.odometry, self._setpoint = tuple(pose), (0.0, 0.0)
        self._model = mujoco.MjModel.from_xml_string(world(name, drive, pose))
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)

    def _of_sides(self, values: 'np.ndarray[tuple[int], np.dtype[np.float64]]') -> tuple[float, float]:
        right, left = np.split(values, 2)
        return float(right.mean()), float(left.mean())

    @property
    def angles(self) -> tuple[float, float]:
        """Of the right and the left wheels [rad]."""
        return self._of_sides(self._data.qpos[7:])

    @property
    def speeds(self) -> tuple[float, float]:
        """Of the right and the left wheels [rad/s]."""
        return self._of_sides(self._data.qvel[6:])

    @property
    def pose(self) -> tuple[float, float, float]:
        """True x, y [m] and heading [rad]."""
        x, y, _, w, i, j, k = self._data.qpos[:7].tolist()
        return x, y, math.atan2(2.0 * (w * k + i * j), w * w + i * i - j * j - k * k)

    @property
    def velocity(self) -> tuple[float, float]:
        """True velocity ahead [m/s] and turn rate [rad/s]."""
        x, y, *_, turn = self._data.qvel[:6].tolist()
        heading = self.pose[2]
        return x * math.cos(heading) + y * math.sin(heading), turn

    def of_wheels(self, right: float, left: float) -> tuple[float, float]:
        """Return the motion ahead and around of wheels that do not slip, of angles [rad] or speeds [rad/s]."""
        return 0.5 * self._radius * (right + left), self._radius * (right - left) / self._separation

    def follow(self, ahead: float, around: float, duration: float) -> None:
        """Advance by a duration [s] with the command of a body's velocities [m/s], [rad/s], along a ramp."""
        self._setpoint = tuple(
            before + max(-most * duration, min(most * duration, after - before))
            for before, after, most in zip(self._setpoint, (ahead, around), RAMP, strict=True))
        middle, half = self._setpoint[0], 0.5 * self._separation * self._setpoint[1]
        self._advance(((middle + half) / self._radius, (middle - half) / self._radius), duration)

    def push(self, right: float, left: float, duration: float) -> None:
        """Advance by a duration [s] with torques of the right and the left wheels [N m]."""
        self._advance((right / self._wheels, left / self._wheels), duration)

    def _advance(self, inputs: tuple[float, float], duration: float) -> None:
        before = self.angles
        self._data.ctrl[:] = np.repeat(inputs, self._wheels)
        mujoco.mj_step(self._model, self._data, round(duration / STEP))
        ahead, around = self.of_wheels(*(now - then for now, then in zip(self.angles, before, strict=True)))
        x, y, heading = self.odometry
        # the chord of the arc
        middle, half = heading + 0.5 * around, 0.5 * around
        chord = ahead * (math.sin(half) / half if half else 1.0)
        self.odometry = x + chord * math.cos(middle), y + chord * math.sin(middle), heading + around


def draw(path: str) -> None:
    """Draw both robots, side by side; needs Pillow and OpenGL, without a screen MUJOCO_GL=osmesa or egl."""
    from PIL import Image  # noqa: PLC0415 (of the picture alone)

    pictures = []
    for name, build in BUILDS.items():
        robot = Robot(name, 'velocity', (0.0, 0.0, 0.0), build.radius, build.separation)
        robot.follow(0.3, 0.5, 2.0)
        camera = mujoco.MjvCamera()
        camera.lookat[:] = *robot.pose[:2], 0.05
        camera.distance, camera.elevation, camera.azimuth = 0.95, -28.0, math.degrees(robot.pose[2]) + 130.0
        with mujoco.Renderer(robot._model, 420, 600) as renderer:
            renderer.update_scene(robot._data, camera)
            pictures.append(renderer.render().copy())
    Image.fromarray(np.hstack(pictures)).quantize(128).save(path, optimize=True)


if __name__ == '__main__':
    draw(sys.argv[1])
