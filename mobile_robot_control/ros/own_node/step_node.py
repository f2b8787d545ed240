"""The node that runs a step function and a table of topics from outside the package."""

from typing import Annotated, Any, NamedTuple

from mobile_robot_control.parameters.declaration import INLINE, ParameterError
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.own_node import OwnNode
from mobile_robot_control.ros.shared.conversions import reader, writer
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import ALL_LOOP_TOPICS, LoopGraph, Topic


def _group(group: Any) -> Any:
    """Return the parameters of a node: those of all nodes of the loop, and its own."""

    class Parameters(NamedTuple):
        shared: Annotated[Shared, INLINE] = Shared()
        own: Annotated[group, INLINE] = group()

    return Parameters


class StepNode(LoopNode[Any]):
    """
    Runs an OwnNode.

    Parameters
    ----------
    own : OwnNode
        The record to run.

    """

    def __init__(self, own: OwnNode) -> None:
        self._own = own
        unknown = sorted({*own.inputs.values(), *own.outputs.values()} - {*ALL_LOOP_TOPICS})
        if unknown:
            raise ParameterError(f"'{like}' is no topic of the loop; write one of {', '.join(ALL_LOOP_TOPICS)}"
                                 for like in unknown)
        super().__init__(own.name, _group(own.parameters))
        self._state = own.start
        rates = {topic: getattr(self.shared, ALL_LOOP_TOPICS[like].rate) for topic, like in own.inputs.items()}
        self._connect({topic: Input(reader(like, self.shared), period_nanoseconds(rates[topic]), lambda _: own.timeout)
                       for topic, like in own.inputs.items()}, own.outputs, next(iter(rates.values())))
        self._start()

    def _loop_graph(self) -> LoopGraph:
        inputs = [_topic(topic, like)._replace(subscribers=(self._own.name,))
                  for topic, like in self._own.inputs.items()]
        outputs = [_topic(topic, like)._replace(publisher=self._own.name) for topic, like in self._own.outputs.items()]
        return LoopGraph({topic.name: topic for topic in (*inputs, *outputs)}, (), (self._own.name,))

    def _writer(self, topic: str) -> Any:
        return writer(self._own.outputs[topic], self.shared)

    def begin_run(self, _inputs: Inputs, _joins: bool) -> None:
        """Begin with the initial state."""
        self._state = self._own.start

    def resume(self) -> None:
        """Begin with the initial state after a rest."""
        self._state = self._own.start

    def step(self, inputs: Inputs, dt: float) -> Outputs:
        """Return the outputs of the step function."""
        self._state, outputs = self._own.step(
            self._state, {topic: value for topic, (_, value) in inputs.messages.items()}, self.parameters.own, dt)
        if outputs.keys() != self._own.outputs.keys():
            raise TypeError(f'the step of {self._own.name} returned {", ".join(outputs) or "nothing"}; its table of '
                            f'outputs has {", ".join(self._own.outputs)}')
        return outputs


def _topic(name: str, like: str) -> Topic:
    return ALL_LOOP_TOPICS[like]._replace(name=name)
