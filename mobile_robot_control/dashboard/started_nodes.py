"""The nodes that the page has started: begun and ended."""

from collections.abc import Callable
from pathlib import Path

from mobile_robot_control.configuration.files import configuration_text
from mobile_robot_control.configuration.nodes import Configuration, loop_of
from mobile_robot_control.experiment.node_processes import NodeProcess, stop_processes
from mobile_robot_control.system.files import write_atomically


class StartedNodes:
    """
    The four nodes as child processes; they end with this process, however it ends.

    Parameters
    ----------
    configuration : Configuration
        What they begin with.
    namespace : str
        In which they run.
    folder : Path
        Takes `parameters.yaml` and the nodes' logs.
    note_node : callable
        Takes the number of each process.

    """

    def __init__(self, configuration: Configuration, namespace: str, folder: Path,
                 note_node: Callable[[int], None] = lambda _: None) -> None:
        self._configuration = configuration
        self._namespace, self._folder, self._note_node = namespace, folder, note_node
        self._processes: list[NodeProcess] = []

    def start(self) -> None:
        """Start all nodes of the loop, each as a process."""
        file, log = self._folder / 'parameters.yaml', self._folder / 'log'
        log.mkdir(parents=True, exist_ok=True)
        write_atomically(file, configuration_text(self._configuration))
        arguments = ['--ros-args', '--params-file', str(file)]
        if self._namespace != '/':
            arguments += ['-r', f'__ns:={self._namespace}']
        for name in loop_of(self._configuration.plant).nodes:
            self._processes.append(NodeProcess([name], arguments, log / f'{name}.log'))
            self._note_node(self._processes[-1].pid)

    def reports(self) -> list[str]:
        """Say of each process that has ended how it did, with the last lines of its log."""
        return [process.exit_report() for process in list(self._processes) if process.exit_code() is not None]

    def stop(self) -> None:
        """End all of them."""
        stop_processes(self._processes)
