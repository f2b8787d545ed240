"""The nodes started by the page: their start, restart and end."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from mobile_robot_control.experiment.node_processes import NodeProcess, stop_processes
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import configuration_text
from mobile_robot_control.settings.nodes import Configuration, loop_of
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import shortened


class StartedNodes:
    """
    The four nodes as child processes; they end with this process, however it ends.

    Parameters
    ----------
    configuration : Configuration
        Initial configuration.
    namespace : str
        Of the nodes.
    folder : Path
        Receives `parameters.yaml` and the nodes' logs.
    note_node : callable
        Takes the number of each process.

    Attributes
    ----------
    configuration : Configuration
        Initial configuration.

    """

    def __init__(self, configuration: Configuration, namespace: str, folder: Path,
                 note_node: Callable[[int], None] = lambda _: None) -> None:
        self.configuration = configuration
        self._namespace, self._folder, self._note_node = namespace, folder, note_node
        self._processes: dict[str, NodeProcess] = {}

    def start(self) -> None:
        """Start all nodes of the loop, each as a process."""
        file = self._folder / 'parameters.yaml'
        (self._folder / 'log').mkdir(parents=True, exist_ok=True)
        write_atomically(file, configuration_text(self.configuration))
        for name in loop_of(self.configuration.plant).nodes:
            self._start(name, file)

    def _start(self, name: str, file: Path) -> None:
        arguments = ['--ros-args', '--params-file', str(file)]
        if self._namespace != '/':
            arguments += ['-r', f'__ns:={self._namespace}']
        self._processes[name] = NodeProcess([name], arguments, self._folder / 'log' / f'{name}.log')
        self._note_node(self._processes[name].pid)

    def restart(self, name: str, present: Mapping[str, Mapping[str, Any]]) -> None:
        """
        Restart a node.

        Parameters
        ----------
        name : str
            Of the node.
        present : mapping of str to mapping of str to object
            Parameters by node; those of the others are checked with its own.

        Raises
        ------
        ParameterError
            If it would refuse them; then it continues unchanged.

        """
        if name not in self._processes:
            raise ParameterError([f'there is no node {shortened(name, 60)} here'])
        file = self._folder / f'parameters_{name}.yaml'
        started = {node: flatten(part) for node, part in self.configuration._asdict().items()}
        configured = configure({node: started[node] | dict(present.get(node, {})) for node in started})
        stop_processes([self._processes[name]])
        write_atomically(file, configuration_text(configured))
        self._start(name, file)

    def signal(self, name: str, number: int) -> None:
        """Send a signal to a node."""
        self._processes[name].signal(number)

    def reports(self) -> dict[str, str]:
        """Describe the end of each process that has ended, with the last lines of its log, by node."""
        return {name: process.exit_report() for name, process in list(self._processes.items())
                if process.exit_code() is not None}

    def stop(self) -> None:
        """End all of them."""
        stop_processes(list(self._processes.values()))
