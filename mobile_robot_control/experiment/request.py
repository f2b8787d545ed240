"""Requested experiments: one, several in sequence, or a replay."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from mobile_robot_control.experiment.folders import WRITTEN, experiment_folders, write_origin
from mobile_robot_control.experiment.foreign_nodes import (
    ForeignNode,
    foreign_nodes,
    read_name,
    read_node,
)
from mobile_robot_control.experiment.node_processes import START
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.reference.curves import OF_FILES
from mobile_robot_control.ros.shared.process import LOAD_ERRORS, Stop, check_environment, load_fault
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.settings.nodes import Configuration, loop_of
from mobile_robot_control.system.files import encodable_path
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.supervisor import Supervisor
from mobile_robot_control.system.texts import distinct, printable

if TYPE_CHECKING:
    from mobile_robot_control.experiment.runner import ExperimentResult, Procedure


class ExperimentRequest(NamedTuple):
    """The request of an experiment."""

    sources: ParameterSources
    output: Annotated[str, Field('', 'folder for all files'), Reader(encodable_path, 'DIR')]
    duration: Annotated[float | None, Field('s', 'simulated time; required without --replay', above=0.0)] = None
    node: Annotated[tuple[tuple[str, tuple[str, ...]], ...], Field(
        '', 'command that is started in place of our node of that name'),
        Reader(read_node, 'NAME=COMMAND', again=True, example="position_controller='python my_node.py'")] = ()
    attach: Annotated[tuple[str, ...], Field(
        '', 'node that runs already in place of ours, such as a robot as the plant'),
        Reader(read_name, 'NAME', again=True, example='plant')] = ()
    overwrite: Annotated[bool, Field('', 'replace an experiment in this folder; other files stay')] = False
    composed: Annotated[bool, Field('', 'run all four nodes in one process')] = False
    compare: Annotated[tuple[str, ...], Field(
        '', 'parameter files to run one after the other, on the same curve from the same start, with one report for '
        'all')] = ()
    replay: Annotated[str | None, Field(
        '', 'folder or bag of an experiment in lockstep: repeat it with all its events, and compare to the last bit'
    )] = None
    report: Annotated[bool, Field('', 'write the metrics without the report')] = True
    namespace: Annotated[str, Field('', 'namespace of the nodes'), Reader(read_namespace, 'NS')] = '/'
    patience: Annotated[float, Field('s', 'wall time without progress before the run is ended; nodes have at '
                                       'least 30 s to start', above=0.0)] = 20.0


class Performed(NamedTuple):
    """
    An experiment that has been run, recorded and evaluated.

    Attributes
    ----------
    result : ExperimentResult
        Its end.
    metrics : dict of str to object
        As `metrics.json`, without its provenance.
    parameters : Configuration
        Of the run.

    """

    result: 'ExperimentResult'
    metrics: dict[str, Any]
    parameters: Configuration


class Experiments:
    """
    The experiments of one request.

    Parameters
    ----------
    request : ExperimentRequest
        The request; ParameterError is raised if its parts contradict each other.
    command_line : str
        Recorded with the results.
    stop : Stop
        Stops them.

    """

    def __init__(self, request: ExperimentRequest, command_line: str, stop: Stop) -> None:
        if request.duration is None and request.replay is None:
            raise ParameterError(['--duration is missing; it is needed without --replay: simulated time [s]'])
        if request.replay is not None and request.compare:
            raise ParameterError(['--replay is not allowed with --compare; replay one run after the other'])
        for option, is_given in (('--replay', request.replay is not None), ('--compare', bool(request.compare))):
            if is_given and request.attach:
                raise ParameterError([f'{option} is not allowed with --attach: what runs already does not begin again; '
                                      'record one run after the other'])
        self._request, self._command_line, self._stop = request, command_line, stop
        self._output = Path(request.output)

        # what it lacks is told before a folder is made
        import mobile_robot_control.runs.new_bag  # noqa: F401, PLC0415 (late: usage errors appear at once)

    def run(self) -> Performed:
        """Run the experiment, or replay one; a refusal raises ParameterError, and changes nothing."""
        if self._request.replay is not None:
            return self._replay()
        parameters = self._configured()
        self._nodes(parameters)  # refused before a folder is made
        check_environment(self._output / 'log')
        with (experiment_folders({self._output: parameters}, self._request.overwrite, self._request.sources.robot
                                 ) as unused, _progress_bar(parameters.plant.duration) as bar):
            return self._perform(parameters, self._output, bar, unused)

    def _configured(self, *files: str) -> Configuration:
        sources = self._request.sources.with_files(*files).with_values({'plant.duration': self._request.duration})
        parameters = sources.configuration(self._request.namespace)
        if not parameters.plant.shared.stamped_cmd_vel:
            raise ParameterError(["stamped_cmd_vel = false: an experiment's topics are joined by their stamps; "
                                  "add -p '/**.stamped_cmd_vel:=true'"])
        return parameters

    def intention(self) -> str:
        """Describe the motion of an attached robot; a refusal raises ParameterError."""
        parameters = self._configured()
        self._nodes(parameters)
        cart = parameters.reference_cart.curve
        course = f'a {cart.curve}' if cart.curve in OF_FILES else (
            f'the {cart.curve} of {cart.placement.scale:g} m, {cart.placement.period:g} s a lap')
        if 'reference_cart' in {*self._request.attach, *(name for name, _ in self._request.node)}:
            course = 'the reference of another cart'
        return f'for {parameters.plant.duration:g} s along {course}'

    def _nodes(self, parameters: Configuration) -> dict[str, ForeignNode]:
        return foreign_nodes(self._request.node, self._request.attach, loop_of(parameters.plant))

    def _perform(
        self, parameters: Configuration, output: Path, bar: tqdm, unused: list[Path],
        course: 'Callable[[], Procedure] | None' = None,
    ) -> Performed:
        """Run, record and evaluate one configuration; the result's reason names every error."""
        request = self._request
        nodes = self._nodes(parameters)
        origin = {name: node.record for name, node in nodes.items()}
        if nodes:
            write_origin(output, self._command_line, origin)
        with Supervisor(max(request.patience, START)) as supervisor:
            # imported late: usage errors appear at once, and an import that hangs is noticed
            try:
                from mobile_robot_control.experiment.evaluation import evaluate  # noqa: PLC0415
                from mobile_robot_control.experiment.runner import run_experiment  # noqa: PLC0415
            except LOAD_ERRORS as error:
                raise ParameterError([load_fault(error)]) from error

            result = run_experiment(parameters, output, request.namespace, composed=request.composed,
                                    patience=request.patience, stop=self._stop, bar=bar, supervisor=supervisor,
                                    course=None if course is None else course(), nodes=nodes)
        unused.remove(output)
        bar.write('experiment: reading the bag and measuring' + (', then drawing the report' if request.report else ''),
                  file=sys.stderr)
        if not result.flow_control:
            origin['plant']['flow_control'] = False
        evaluated = evaluate(output, request.namespace, result.outcome, self._command_line,
                             quiet=bool(request.compare), with_report=request.report, nodes=origin)
        reasons = [*filter(None, [result.reason]), *evaluated.unwritten]
        return Performed(result._replace(reason='\nexperiment: '.join(reasons)), evaluated.metrics, parameters)

    def _replay(self) -> Performed:
        """Repeat a recorded run, and compare the two."""
        # imported late: most runs replay nothing
        from mobile_robot_control.experiment.replay_plan import compare_replay, plan_replay  # noqa: PLC0415

        request, output = self._request, self._output
        replay = plan_replay(Path(str(request.replay)), output, request.sources, request.duration, request.namespace,
                             self._nodes)

        def course() -> 'Procedure':
            from mobile_robot_control.experiment.replay_run import ReplayRun  # noqa: PLC0415 (imports rclpy)

            return ReplayRun(replay)

        parameters = replay.configuration
        check_environment(output / 'log')
        with (experiment_folders({output: parameters}, request.overwrite) as unused,
              _progress_bar(parameters.plant.duration * len(replay.runs)) as bar):
            performed = self._perform(parameters, output, bar, unused, course)
        result = performed.result
        if result.outcome != 'interrupted' and not result.reason:
            result = result._replace(reason=compare_replay(replay, output, request.namespace))
        return performed._replace(result=result)

    def compare(self) -> list[str]:
        """Run several configurations in sequence, and report them together; return the errors."""
        # imported late: usage errors appear at once
        from mobile_robot_control.report.request import refuse_too_many, report  # noqa: PLC0415

        request, output = self._request, self._output
        refuse_too_many(len(request.compare))
        names = _folders(request.compare)
        configured = [self._configured(file) for file in request.compare]
        chosen = {name: _alike(parameters, configured[0]) for name, parameters in zip(names, configured, strict=True)}
        for parameters in chosen.values():
            self._nodes(parameters)
        check_environment(output / names[0] / 'log')
        reasons: list[str] = []
        done: list[tuple[str, Path]] = []
        folders = {output / name: parameters for name, parameters in chosen.items()}
        with (experiment_folders(folders, request.overwrite, request.sources.robot) as unused,
              _progress_bar(configured[0].plant.duration * len(chosen)) as bar):
            for name, parameters in chosen.items():
                bar.set_description(name)
                result = self._perform(parameters, output / name, bar, unused).result
                done.append((name, output / name))
                if result.reason:
                    reasons.append(f'{name}: {result.outcome}: {result.reason}')
                if self._stop.requested:
                    reasons.append(f'{name}: interrupted')
                    break
        for reason in reasons:
            print(f'experiment: {reason}', file=sys.stderr)
        print(f'experiment: drawing the report over {len(done)} runs', file=sys.stderr)
        return reasons + report(done, output, self._command_line, request.namespace, quiet=True)


def _progress_bar(seconds: float) -> tqdm:
    """Make a bar over the simulated time of all runs [s]."""
    return tqdm(total=seconds, desc='simulated', bar_format='{l_bar}{bar}| {n:.1f}/{total:.1f} s '
                '[{elapsed}<{remaining}]')


def _alike(chosen: Configuration, first: Configuration) -> Configuration:
    """Return a configuration with the curve and the start of the first one."""
    return chosen._replace(
        reference_cart=chosen.reference_cart._replace(curve=first.reference_cart.curve),
        plant=chosen.plant._replace(initial_pose=first.plant.initial_pose),
    )


def _folders(files: Sequence[str]) -> list[str]:
    """Return the name of each run's folder within the output; raise ParameterError if it would leave the output."""
    names = distinct([printable(Path(file).stem) for file in files])
    odd = [f"--compare {file}: its run would be written to '{name}', which has another use; rename the file"
           for file, name in zip(files, names, strict=True) if name in ('', '.', '..', *WRITTEN)]
    if odd:
        raise ParameterError(odd)
    return names
