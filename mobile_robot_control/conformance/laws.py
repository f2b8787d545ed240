"""The checks of a law by name."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial

from mobile_robot_control.conformance.checks import Check, Conformance, refused, run_checks, with_dds
from mobile_robot_control.conformance.compiled_form import compiled_equals_plain
from mobile_robot_control.conformance.holding import holding
from mobile_robot_control.conformance.law_runs import (
    begins_again,
    survives_a_run,
    survives_a_standing_cart,
    survives_a_switch,
)
from mobile_robot_control.conformance.law_steps import (
    finite,
    gains_are_safe,
    inputs_unchanged,
    pure,
    repair_is_sound,
)
from mobile_robot_control.conformance.over_dds import equal_over_dds, file_option
from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS, groups_of
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reference.curves import CURVES

LAW_CHECKS: dict[str, Callable[[Law], Iterator[str]]] = {
    'pure': pure,
    'inputs unchanged': inputs_unchanged,
    'finite': finite,
    'gains': gains_are_safe,
    'repair': repair_is_sound,
    'run': survives_a_run,
    'switch': survives_a_switch,
    'restart': begins_again,
    'standing cart': survives_a_standing_cart,
    'compiled': compiled_equals_plain,
}


def _over_dds(law: Law) -> Iterator[str]:
    yield from equal_over_dds(file_option(LAWS, law, law.step, '--law'), law.name, next(iter(CURVES)))


def checked_law(law: Law, over_dds: bool) -> Conformance:
    """Make all checks of a law; see `testing.check_law`."""
    subject = f"the law '{getattr(law, 'name', law)}'"
    with ExitStack() as held:
        try:
            held.enter_context(holding(LAWS, law))
            groups_of(law)
        except ParameterError as error:
            refused(subject, error.violations)
        checks: dict[str, Check] = {name: partial(check, law) for name, check in LAW_CHECKS.items()}
        return run_checks(subject, with_dds(checks, partial(_over_dds, law), over_dds))
