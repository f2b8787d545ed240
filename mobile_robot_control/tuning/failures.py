"""The scenarios in which a controller fails in a study: in words, and as in `study.json`."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from mobile_robot_control.simulation.scenarios import Scenario
from mobile_robot_control.tuning.monte_carlo import Judged
from mobile_robot_control.tuning.splits import FEW, QUANTITIES, Quantity, best_split, shown

_ENDS = {'completed': 'too far from the reference over the last quarter', 'diverged': 'diverged',
         'law_failed': 'with a position law that failed'}


def _failed(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> list[tuple[int, Scenario, Judged]]:
    """Return number (from 1), scenario and run of the failures."""
    return [(number, scenario, run) for number, (scenario, run) in enumerate(
        zip(scenarios, judged, strict=False), 1) if not run.success]


def scenario_text(scenario: Scenario) -> str:
    """Describe the conditions of a run."""
    return ', '.join(f'{quantity.words} {shown(name, quantity.of(scenario))}' for name, quantity in QUANTITIES.items())


def failure_texts(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> Iterator[str]:
    """Yield sentences on the failures of a controller; none if there are none."""
    failed = _failed(scenarios, judged)
    if not failed:
        return
    ends = Counter(run.outcome for _, _, run in failed)
    how = ', '.join(f'{count} {_ENDS[outcome]}' if len(ends) > 1 else _ENDS[outcome]
                    for outcome, count in sorted(ends.items()))
    yield f'{len(failed)} of {len(judged)} {"fails" if len(failed) == 1 else "fail"}: {how}'
    if len(failed) <= FEW:
        yield from (f'run {number}: {scenario_text(scenario)}' for number, scenario, _ in failed)
        return
    split = best_split(scenarios, judged)
    if split:
        (there, drawn), (rest, others) = split.there, split.elsewhere
        yield f'{there} of them with {split.words}: {there} of {drawn} fail there, {rest} of {others} elsewhere'
        return
    ranges = '; '.join(f'{QUANTITIES[name].words} {_range_text(name, found)}'
                       for name, found in _ranges(scenarios, judged, success=False).items())
    yield f'no single quantity tells them from the others: they have {ranges}' if len(failed) < len(judged) else ranges


def _range_text(name: str, found: Sequence[Any]) -> str:
    """Describe the range of a quantity over at least one value."""
    low, high = found[0], found[-1]
    if isinstance(low, str):
        return ', '.join(found)
    return f'{low:.3g} to {shown(name, high)}' if low < high else shown(name, high)


def _ranges(scenarios: Sequence[Scenario], judged: Sequence[Judged], success: bool) -> dict[str, list[Any]]:
    """Return the range of each quantity among failures or successes; for names all values, and [] without any run."""
    chosen = [scenario for scenario, run in zip(scenarios, judged, strict=False) if run.success is success]

    def of(quantity: Quantity) -> list[Any]:
        values = sorted({quantity.of(scenario) for scenario in chosen})
        return values if not values or isinstance(values[0], str) else [values[0], values[-1]]

    return {name: of(quantity) for name, quantity in QUANTITIES.items()}


def failure_values(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> dict[str, Any]:
    """Return the failures of a controller, as in `study.json`."""
    failed, split = _failed(scenarios, judged), best_split(scenarios, judged)
    return {
        'count': len(failed),
        'outcomes': dict(sorted(Counter(run.outcome for _, _, run in failed).items())),
        'split': split._asdict() | {'words': split.words} if split else None,
        'ranges': {'failures': _ranges(scenarios, judged, success=False),
                   'successes': _ranges(scenarios, judged, success=True)},
        'scenarios': [{'run': number, 'outcome': run.outcome} | {
            name: quantity.of(scenario) for name, quantity in QUANTITIES.items()} | {
            'noise_seed': scenario.noise.seed} for number, scenario, run in failed],
    }
