from collections.abc import Collection, Mapping, Sequence
from os import PathLike

from mobile_robot_control import elementary as elementary
from mobile_robot_control.benchmarking.benchmark import Benchmarked as Benchmarked
from mobile_robot_control.control.law import Law as Law
from mobile_robot_control.control.law import NoState as NoState
from mobile_robot_control.control.laws import LAWS as LAWS
from mobile_robot_control.control.velocity_law import VelocityInputs as VelocityInputs
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS as VELOCITY_LAWS
from mobile_robot_control.control.velocity_laws import VelocityLaw as VelocityLaw
from mobile_robot_control.drives.loading import load as load
from mobile_robot_control.identification.request import identify as identify
from mobile_robot_control.identification.result import Identification as Identification
from mobile_robot_control.jit import jitable as jitable
from mobile_robot_control.parameters.declaration import Field as Field
from mobile_robot_control.parameters.declaration import ParameterError as ParameterError
from mobile_robot_control.parameters.declaration import rule as rule
from mobile_robot_control.parameters.plugins import register as register
from mobile_robot_control.planning.planning import Plan as Plan
from mobile_robot_control.planning.request import plan as plan
from mobile_robot_control.quantities import BodyVelocity as BodyVelocity
from mobile_robot_control.quantities import Observation as Observation
from mobile_robot_control.quantities import Pose as Pose
from mobile_robot_control.quantities import Reference as Reference
from mobile_robot_control.quantities import TrackingError as TrackingError
from mobile_robot_control.quantities import WheelTorque as WheelTorque
from mobile_robot_control.reference.curves import CURVES as CURVES
from mobile_robot_control.reference.curves import Curve as Curve
from mobile_robot_control.reference.curves import CurvePoint as CurvePoint
from mobile_robot_control.runs.metrics import summary as summary
from mobile_robot_control.runs.request import simulate as simulate
from mobile_robot_control.runs.rollout import measure as measure
from mobile_robot_control.runs.rollout import rollout as rollout
from mobile_robot_control.runs.run import Run as Run
from mobile_robot_control.search.result import Tuned as Tuned
from mobile_robot_control.settings.configure import configure as configure
from mobile_robot_control.settings.law_sets import shipped as shipped
from mobile_robot_control.settings.nodes import Configuration as Configuration
from mobile_robot_control.studying.study import Study as Study
from mobile_robot_control.version import __version__ as __version__

_File = str | PathLike[str]

def benchmark(
    *files: _File,
    tracks: Collection[_File] = (),
    parameters: Mapping[str, object] | None = None,
    progress: bool = False,
    laws: Collection[str] = (),
    velocity_laws: Collection[str] = (),
    seed: int = 1,
    seeds: Collection[int] = (),
    budgets: Collection[int] = (500,),
    restarts: int = 2,
    objective: str | None = None,
    feedforward: bool = False,
    tune: bool = True,
    scenarios: int = 8,
    runs: int = 100,
    against: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = 'cpu',
) -> Benchmarked: ...

def tune(
    controller: str,
    *files: _File,
    seed: int,
    robot: _File | None = None,
    parameters: Mapping[str, object] | None = None,
    progress: bool = False,
    algorithm: str = 'nelder_mead',
    population: int | None = None,
    generations: int | None = None,
    time_limit: float | None = None,
    bounds: Mapping[str, tuple[float, float]] = {},
    keep: Collection[str] = (),
    with_velocity: bool = False,
    objective: str = 'eq29',
    combine: str = 'mean',
    literal_torque: bool = False,
    smooth: float | None = None,
    laps: float = 1.0,
    curves: Collection[str] = (),
    scales: Collection[float] = (),
    start: Collection[tuple[float, float, float]] = (),
    mass: Collection[float] = (1.0,),
    friction: Collection[float] = (1.0,),
    delays: Collection[int] = (),
    coulomb: Collection[float] = (),
    random: int = 0,
    variation: float = 0.2,
    within: float = 1.0,
    scenario_seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = 'cpu',
) -> Tuned: ...

def study(
    *files: _File,
    runs: int,
    seed: int,
    compare: Mapping[str, _File | Mapping[str, object]] | Sequence[_File] | _File = (),
    robot: _File | None = None,
    parameters: Mapping[str, object] | None = None,
    progress: bool = False,
    laps: float = 2.0,
    curves: Collection[str] = ('trifolium', 'lemniscate'),
    scales: Collection[float] = (0.5, 1.0),
    within: float = 1.0,
    variation: float | None = None,
    robot_uncertainty: _File | None = None,
    noise_pose: Collection[float] = (),
    noise_velocity: float | None = None,
    longest_delay: int | None = None,
    metric: Collection[str] = ('late_max_position_error', 'rms_position_error'),
    success_within: float = 0.1,
    settled_within: float = 0.02,
    map: Mapping[str, tuple[float, float]] = {},
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = 'cpu',
) -> Study: ...
