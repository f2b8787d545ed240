"""The law and the curve of a file that is to be checked."""

import sys

from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.reference.curve import Curve
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.registry import PluginError


def records_of(file: str) -> tuple[Law | None, Curve | None]:
    """Return LAW and CURVE of a file, None for the one that it lacks; raise PluginError where it has neither."""
    law = curve = None
    refusals: list[str] = []
    try:
        law = LAWS.load_file(file)
    except PluginError as refusal:
        refusals.append(str(refusal))
    if law is None and 'has no LAW' not in refusals[0]:
        raise PluginError(refusals)
    if law is None or 'CURVE' in vars(sys.modules[law.step.__module__]):
        try:
            curve = CURVES.load_file(file)
        except PluginError as refusal:
            if law is None and 'has no CURVE' in str(refusal):
                raise PluginError([f'{file}: has neither LAW nor CURVE; see docs/extending.md']) from None
            raise
    if law is not None and curve is not None:
        # the file was imported again, and its newest records belong together
        law = vars(sys.modules[curve.point.__module__])['LAW']
        LAWS.register(law)
    return law, curve
