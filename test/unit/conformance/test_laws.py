"""The checks of laws: sound ones pass, and what is broken in one way is named with the input that shows it."""

import warnings
from functools import partial
from typing import Annotated, NamedTuple

import pytest
from helpers.broken_laws import BROKEN, MIXED, PAIR, SOLVING, SOUND, Count

from mobile_robot_control import Field
from mobile_robot_control.conformance.checks import ConformanceError, LeftOutError, file_option, holding, run_checks
from mobile_robot_control.conformance.laws import LAW_CHECKS
from mobile_robot_control.control.laws import BUILT_IN, LAWS
from mobile_robot_control.testing import check_law

# the one that compiles takes a second
PLAIN = [name for name in LAW_CHECKS if name != 'compiled']


def checked_plain(law):
    with holding(LAWS, law):
        return run_checks(law.name, {name: partial(LAW_CHECKS[name], law) for name in PLAIN})


@pytest.mark.parametrize('law', BUILT_IN, ids=lambda law: law.name)
def test_the_laws_of_the_package_pass_and_are_compiled_to_the_last_bit(law):
    pytest.importorskip('numba')
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        result = check_law(law, over_dds=False)
    assert {*result.passed, *result.left_out} == {'record', *LAW_CHECKS, 'over DDS'}
    assert LAWS[law.name] is law
    assert result.left_out == {'over DDS': 'over_dds=False'} | (
        {} if law.repair else {'repair': 'the law has no repair'})


@pytest.mark.parametrize('law', [SOUND, MIXED, PAIR, SOLVING], ids=lambda law: law.name)
def test_a_sound_law_passes_and_gains_that_a_rule_refuses_are_not_tried(law):
    before = dict(LAWS)
    assert set(PLAIN) - {'repair'} <= set(checked_plain(law).passed)
    assert dict(LAWS) == before


@pytest.mark.parametrize('what', BROKEN)
def test_what_is_broken_is_named_with_an_input(what):
    law, failing, (check, *texts) = BROKEN[what]
    with pytest.raises(ConformanceError) as failure:
        checked_plain(law)
    assert set(failure.value.failures) == failing
    line = next(line for line in str(failure.value).splitlines() if line.startswith(f'  {check}: '))
    assert all(text in line for text in texts), line


class TooLarge(NamedTuple):
    k: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0, maximum=2.0, live=True)] = 3.0


@pytest.mark.parametrize(('record', 'text'), [
    ('kanayama', 'LAW is of type str'),
    (SOUND._replace(name='No name'), "the name 'No name' of a law is no ROS name"),
    (SOUND._replace(name='fuzzy'), "the law 'fuzzy' is defined in mobile_robot_control already"),
    (SOUND._replace(gains=dict), "'sound': its gains are no NamedTuple"),
    (SOUND._replace(step=None), "the step of 'sound' is no function"),
    (SOUND._replace(start=5), "'sound': its start is 5; write an instance of a NamedTuple"),
    (SOUND._replace(joining=Count), "'sound': its joining is <class 'helpers.broken_laws.Count'>; write an instance"),
    (SOUND._replace(groups=('sound', 'nothing')), "takes the gains of 'nothing', which is no law here"),
    (SOUND._replace(gains=TooLarge), 'k = 3.0 is not allowed; it must be above 0.0 1/s, at most 2.0 1/s'),
    (SOUND._replace(gains=Count), 'its gains are no NamedTuple of fields annotated with Field'),
])
def test_an_incomplete_record_is_refused_alone_and_leaves_the_registry_as_it_was(record, text):
    before = dict(LAWS)
    with pytest.raises(ConformanceError) as failure:
        check_law(record, over_dds=False)
    assert list(failure.value.failures) == ['record']
    assert text in str(failure.value)
    assert dict(LAWS) == before


def test_a_law_that_is_not_of_a_file_is_left_out_over_dds():
    with holding(LAWS, SOUND), pytest.raises(LeftOutError, match='not the LAW of a file or an installed package'):
        file_option(LAWS, SOUND, SOUND.step, '--law')


def test_each_failed_check_is_named_with_its_first_input_and_what_is_left_out_is_told():
    def missing():
        raise LeftOutError('no numba')

    assert str(run_checks('a law', {'pure': lambda: [], 'compiled': missing})) == (
        'a law:\n  passed: record\n  passed: pure\n  left out: compiled (no numba)')
    with pytest.raises(ConformanceError) as failure:
        run_checks('a law', {'pure': lambda: ['at 1', 'at 2'], 'finite': lambda: 1 / 0, 'gains': lambda: []})
    assert str(failure.value) == (
        'a law fails 2 checks:\n  pure: at 1\n  finite: ZeroDivisionError: division by zero')
