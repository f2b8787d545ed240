"""The law and the curve of a file that is to be checked."""

import sys

from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.reference.curves import CURVES, Curve
from mobile_robot_control.registry import PluginError


def records_of(file: str) -> tuple[Law | None, Curve | None]:
    """Return LAW and CURVE of a file, None for the one that it lacks; raise PluginError where it has neither."""
    law: Law | None = None
    try:
        law = LAWS.load_file(file)
    except PluginError as refusal:
        # a file of a curve alone is refused as that of a law
        curve = CURVES.load_file(file) if 'has no LAW' in str(refusal) else None
        if curve is None:
            raise
        return None, curve
    has_curve = hasattr(sys.modules[law.step.__module__], 'CURVE')
    return law, CURVES.load_file(file) if has_curve else None
