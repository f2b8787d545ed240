"""The register of functions that numba compiles."""

from mobile_robot_control import jit
from mobile_robot_control.control import backstepping, fuzzy, hybrid_backstepping, velocity_pi
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.base import base_step
from mobile_robot_control.model.plant import actuated_step
from mobile_robot_control.reference.curves import CURVES


def test_functions_are_returned_and_registered_those_apart_in_a_second_register_too(monkeypatch):
    monkeypatch.setattr(jit, 'JITABLE', [])
    monkeypatch.setattr(jit, 'APART', set())
    assert [jit.jitable(abs), jit.jitable_apart(len)] == [abs, len] == jit.JITABLE
    assert {len} == jit.APART


def test_everything_a_rollout_calls_is_marked():
    assert {law.step for law in LAWS.values()} | {curve.point for curve in CURVES.values()} | {
        backstepping.step, fuzzy.surface, hybrid_backstepping.fade_step, velocity_pi.step, dynamics.step,
        dynamics.diverged, actuated_step, base_step} <= set(jit.JITABLE)
