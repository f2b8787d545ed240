"""One dashboard and one page for all tests in a browser; each finds both as the first one did."""

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from helpers.domains import own_domain
from helpers.live_page import PLUGINS, LivePage, OpenPage
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from std_srvs.srv import Trigger

from mobile_robot_control.settings.nodes import NODES


class Asker:
    """A node that reads the parameters of others, and sets them back."""

    def __init__(self):
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        self._node = rclpy.create_node('asker', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._clients = {}
        self._diagnostics = self._node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._first = self._values()

    def _ask(self, kind, node, name, **request):
        client = self._clients.get((node, name))
        if client is None:
            client = self._clients[node, name] = self._node.create_client(kind, f'{node}/{name}')
        assert client.wait_for_service(20.0), node
        for _ in range(10):  # a response to a client that the node has not discovered yet is lost
            answer = client.call_async(kind.Request(**request))
            self._executor.spin_until_future_complete(answer, 3.0)
            if answer.done():
                return answer.result()
        raise AssertionError(f'{node} does not answer')

    def _read(self, node, names):
        values = self._ask(GetParameters, node, 'get_parameters', names=names).values
        return dict(zip(names, map(parameter_value_to_python, values), strict=True))

    def _values(self):
        return {node: self._read(node, self._ask(ListParameters, node, 'list_parameters').result.names)
                for node in NODES}

    def value(self, node, name):
        """Return a value of a node."""
        return self._read(node, [name])[name]

    def restore(self):
        """Set every parameter back to its value at the start; another curve acts from a new run on."""
        before = self._values()
        for node, values in before.items():
            changed = {name: first for name, first in self._first[node].items() if values[name] != first}
            if changed:
                self._ask(SetParameters, node, 'set_parameters', parameters=[
                    Parameter(name, value=value).to_parameter_msg() for name, value in changed.items()])
        if before['reference_cart']['curve'] != self._first['reference_cart']['curve']:
            self._ask(Trigger, 'plant', 'reset')

    def report(self, text):
        """Publish what pretends to be the plant's diagnostics."""
        self._diagnostics.publish(DiagnosticArray(status=[DiagnosticStatus(name='plant', message=text)]))

    def close(self):
        self._executor.shutdown()
        rclpy.shutdown(context=self._context)


# not of the session: it would drive on beside all other tests
@pytest.fixture(scope='package')
def live(tmp_path_factory):
    """One dashboard for all tests that handle the robot, which is slow to leave time for other tests."""
    with own_domain() as variables:
        law = tmp_path_factory.mktemp('law') / 'kanayama.py'
        law.write_bytes((PLUGINS / 'kanayama.py').read_bytes())
        started = LivePage(tmp_path_factory.mktemp('dashboard'), '--law', str(law), '--curve',
                           str(PLUGINS / 'ellipse.py'), '-p', 'plant.real_time_factor:=0.2', '-p',
                           'position_controller.controller_type:=backstepping', environment=variables)
        started.law = law
        # for as long as the node is made: other tests have domains of their own
        with pytest.MonkeyPatch.context() as patch:
            for name, value in variables.items():
                patch.setenv(name, value)
            started.asker = Asker()
        yield started
        started.asker.close()
        started.close()


@pytest.fixture
def page(browser, live):
    """Its page, opened anew at the width of a desktop; the robot as it was at the start."""
    browser.call('Emulation.setDeviceMetricsOverride', width=1280, height=900, deviceScaleFactor=1, mobile=False)
    browser.media('', 'light')
    browser.errors(), browser.requests()
    opened = OpenPage(browser, live.address)
    # the server hears of what was set back a moment later
    opened.wait(lambda: browser.evaluate(
        'document.getElementById("pause").textContent === "Pause" && document.getElementById("speed").value === "0.2"'
        '&& document.getElementById("law").value === "backstepping" && !document.querySelector(".parameter.changed")'))
    yield opened
    browser.close_other_windows()
    # what a test has asked for last is not done in the next one
    opened.settle()
    errors, requests = browser.errors(), browser.requests()
    browser.driver.get('about:blank')
    if len(live.nodes()) < len(NODES):  # a test has failed after it had killed one
        live.close()
        live.start()
    live.asker.restore()
    assert not errors
    assert all(address.startswith((live.address, 'blob:', 'chrome:')) for address in requests)
