"""Trees of NamedTuples as rows of floats, and back."""

import pytest
from helpers.measuring import selecting
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop.trial import make_trial, prepared_loop
from mobile_robot_control.quantities import Pose
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.trees import flat, reader, repeated, shape_of

NUMBERS = st.one_of(st.floats(allow_nan=False), st.integers(-2**53, 2**53), st.booleans())
TREES = st.recursive(NUMBERS, lambda inner: st.one_of(
    st.lists(inner, max_size=4).map(tuple), st.tuples(inner, inner, inner).map(lambda one: Pose(*one))))


def _same(a, b):
    return type(a) is type(b) and (
        len(a) == len(b) and all(map(_same, a, b)) if isinstance(a, tuple) else repr(a) == repr(b))


@given(TREES)
def test_a_tree_comes_back_from_its_row(tree):
    assert _same(reader(shape_of(tree))(flat(tree)), tree)


@pytest.mark.parametrize('robot', [None, 'create3', 'turtlebot3_burger'])
@pytest.mark.parametrize('law', LAWS)
def test_so_do_the_state_and_the_constants_of_each_law_on_each_drive(law, robot):
    loop = ParameterSources(robot=robot).with_values(selecting(law))
    trial = make_trial(loop.configuration(), 1.0)
    tree = trial.state, prepared_loop(trial)
    assert _same(reader(shape_of(tree))(flat(tree)), tree)


def test_what_is_no_number_is_refused_and_an_item_is_repeated():
    with pytest.raises(TypeError, match="cannot hold 'a'"):
        shape_of((1.0, 'a'))
    assert [repeated(n)(0.5) for n in (0, 1, 3)] == [(), (0.5,), (0.5, 0.5, 0.5)]
