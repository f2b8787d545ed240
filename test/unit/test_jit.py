"""The register of functions that numba compiles."""

from mobile_robot_control import jit
from mobile_robot_control.control import backstepping, fuzzy, hybrid_backstepping, velocity_pi
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.base_motion import base_step
from mobile_robot_control.model.plant import actuated_step
from mobile_robot_control.reference.curves import CURVES


def test_jitable_returns_the_function_itself_and_registers_it(monkeypatch):
    monkeypatch.setattr(jit, 'JITABLE', [])

    def double(x):
        return 2.0 * x

    assert jit.jitable(double) is double
    assert [double] == jit.JITABLE


def test_jitable_apart_registers_it_beside_those_that_are_compiled_by_themselves(monkeypatch):
    monkeypatch.setattr(jit, 'JITABLE', [])
    monkeypatch.setattr(jit, 'APART', set())

    def double(x):
        return 2.0 * x

    assert jit.jitable_apart(double) is double
    assert [double] == jit.JITABLE
    assert {double} == jit.APART


def test_everything_a_rollout_calls_is_marked():
    assert {law.step for law in LAWS.values()} <= set(jit.JITABLE)
    assert {curve.point for curve in CURVES.values()} <= set(jit.JITABLE)
    for function in (backstepping.step, fuzzy.surface, hybrid_backstepping.fade_step, velocity_pi.step, dynamics.step,
                     dynamics.diverged, actuated_step, base_step):
        assert function in jit.JITABLE
