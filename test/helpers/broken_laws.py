"""Laws that are broken, each in one way, and sound ones beside them."""

import itertools
import math
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law, rule


class Gains(NamedTuple):
    k: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0, maximum=2.0, live=True,
                              search=(0.0, 2.0))] = 1.0


class Count(NamedTuple):
    ticks: float = 0.0


def command(observation, k=1.0):
    """Return what a sound law commands."""
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    return BodyVelocity(v_r * math.cos(e3) + k * e1, omega_r + v_r * e2 + math.sin(e3))


def sound_step(state, observation, gains, dt):
    return state, command(observation, gains.k)


SOUND = Law('sound', sound_step, Gains)

def driving(k, ticks=lambda state, observation: state):
    """Return a step whose gain is computed of state, observation and gains, and its next state of the first two."""
    return lambda state, observation, gains, dt: (
        ticks(state, observation), command(observation, k(state, observation, gains)))


def counted(state, observation):
    return Count(state.ticks + 1.0)


def standing(state, observation):
    return Count(state.ticks + 1.0 if observation.reference.velocity == (0.0, 0.0) else 0.0)


_calls = itertools.count(1)


def table_writing_step(state, observation, table, dt):
    table[1] = observation.error.longitudinal
    return state, command(observation, table[0])


class Solver:
    """Cannot be copied or pickled, as many solvers; with `remembers` its answer depends on the one before."""

    def __init__(self, k, remembers=False):
        self.k, self.remembers, self.before = k, remembers, 0.0
        self.library, self.itself = math, self

    def solve(self, error):
        before = self.before
        if self.remembers:
            self.before = error
        return self.k * (error + 0.1 * before)


def solving_step(state, observation, solver, dt):
    """Ask a solver that `prepare` has made."""
    return state, command(observation, solver.k)._replace(
        linear=observation.reference.velocity.linear + solver.solve(observation.error.longitudinal))


def no_command_step(state, observation, gains, dt):
    return state, tuple(command(observation, gains.k))


pole_step = driving(lambda state, observation, gains: 1.0 / (2.0 - gains.k))


class Kept(NamedTuple):
    k: float = 0.0


def keeping_step(state, observation, gains, dt):
    """Fails when a gain changes in mid-run."""
    k = gains.k if state.k == 0.0 else state.k
    return Kept(k), command(observation, 1.0 / float(k == gains.k))


class Memory(NamedTuple):
    seen: list


def remembering_step(state, observation, gains, dt):
    """Keeps what it has seen in its start."""
    state.seen[0] = (state.seen[0] + 1.0) % 7.0
    return state, command(observation, gains.k + state.seen[0])


class Unbounded(NamedTuple):
    k: Annotated[float, Field('', 'larger grows', above=0.0, live=True, search=(0.0, 2.0))] = 1.0


class Mixed(NamedTuple):
    """Gains of every kind."""

    table: Annotated[tuple[float, ...], Field('', 'larger drives faster', minimum=0.0, maximum=1.0, length=2, live=True,
                                              search=((0.0, 1.0), (0.0, 1.0)))] = (0.5, 0.5)
    order: Annotated[int, Field('', 'larger drives faster', minimum=0, maximum=3, live=True)] = 1
    mode: Annotated[str, Field('', 'how it drives', choices=('slow', 'fast'), live=True)] = 'slow'
    reverse: Annotated[bool, Field('', 'whether it drives backwards', live=True)] = False


MIXED = Law('mixed', driving(lambda state, observation, gains: sum(gains.table) + gains.order), Mixed)


class Pair(NamedTuple):
    low: Annotated[float, Field('', 'larger is nearer to high', minimum=0.0, maximum=1.0, live=True,
                                search=(0.0, 1.0))] = 0.2
    high: Annotated[float, Field('', 'larger is farther from low', minimum=0.0, maximum=1.0, live=True,
                                 search=(0.0, 1.0))] = 0.8


@rule
def _low_is_lower(pair: Pair):
    if not pair.low < pair.high:
        yield f'low = {pair.low} must be below high = {pair.high}; lower it'


# divides by what a rule keeps positive
between_step = driving(lambda state, observation, gains: 1e-3 / (gains.high - gains.low))


def ordered(pair):
    low, high = sorted(pair)
    return Pair(low, high if high > low else low + 1e-6) if low < 1.0 else Pair(0.5, 1.0)


def raising_repair(pair):
    raise ArithmeticError(f'cannot mend {pair.low}')


def unprepared(gains, dt):
    if gains.k >= 2.0:
        raise ValueError('no solution')
    return gains


PAIR = Law('pair', between_step, Pair, repair=ordered)

SOLVING = Law('solving', solving_step, Gains, prepare=lambda gains, dt: Solver(gains.k))


def broken(k, gains=Gains, *states, ticks=lambda state, observation: state):
    return Law('broken', driving(k, ticks), gains, *states)


BROKEN = {
    # what is broken: the law, the checks that fail, and what the error names
    'impure by a counter': (broken(lambda state, seen, gains: gains.k + 1e-9 * next(_calls)),
                            {'pure', 'restart'}, ('pure', 'later', 'e1 = ')),
    'writes its prepared table': (
        Law('broken', table_writing_step, Gains, prepare=lambda gains, dt: [gains.k, 0.0]), {'inputs unchanged'},
        ('inputs unchanged', 'changes its prepared gains', 'e1 = ')),
    'a solver that remembers': (
        SOLVING._replace(name='broken', prepare=lambda gains, dt: Solver(gains.k, remembers=True)),
        {'pure', 'inputs unchanged', 'restart'}, ('pure', 'later', 'e1 = ')),
    'not a number at e1 = 0': (
        broken(lambda state, seen, gains: gains.k if seen.error.longitudinal != 0.0 else math.nan),
        {'finite', 'gains', 'run', 'switch', 'standing cart'}, ('finite', 'v = nan m/s', 'e1 = 0.0 m')),
    'divides by v_r': (
        broken(lambda state, seen, gains: gains.k / seen.reference.velocity.linear),
        {'finite', 'gains', 'switch', 'standing cart'}, ('standing cart', 'ZeroDivisionError', 'v_r = 0.0 m/s')),
    'returns no command': (
        Law('broken', no_command_step, Gains), {'finite', 'gains', 'run', 'switch', 'standing cart'},
        ('finite', 'write return state, BodyVelocity(v, omega)', 'e1 = 0.0 m')),
    'fails when the cart stands for ten ticks': (
        broken(lambda state, seen, gains: gains.k / max(10.0 - standing(state, seen).ticks, 0.0), Gains, Count(),
               ticks=standing),
        {'standing cart'}, ('standing cart', 'in a simulated run behind a cart that stands', 'error=')),
    'fails at the 81st tick of a run': (
        broken(lambda state, seen, gains: gains.k / max(80.0 - state.ticks, 0.0), Gains, Count(), ticks=counted),
        {'run', 'switch', 'standing cart'},
        ('run', 'ZeroDivisionError: float division by zero, in a simulated run', 'error=')),
    'has a pole at the bound of a gain': (
        Law('broken', pole_step, Gains), {'gains', 'run'},
        ('gains', 'broken.k = 2.0; bound the gain by its Field', 'e1 = ')),
    'has a gain without a bound': (
        broken(lambda state, seen, gains: math.exp(gains.k), Unbounded), {'gains'},
        ('gains', 'OverflowError', 'broken.k = 1000000000000.0; bound the gain')),
    'has a pole within its search': (
        Law('broken', pole_step, Unbounded), {'gains', 'run'},
        ('gains', 'broken.k = 2.0; narrow what the Field names as search', 'e1 = ')),
    'fails at the end of an element': (
        broken(lambda state, seen, gains: 1.0 / (1.0 - gains.table[1]), Mixed), {'gains', 'run'},
        ('gains', 'broken.table = (0.5, 1.0); bound')),
    'fails for a whole number': (
        broken(lambda state, seen, gains: 1.0 / gains.order, Mixed), {'gains'}, ('gains', 'broken.order = 0; bound')),
    'fails for a choice': (
        broken(lambda state, seen, gains: {'slow': 1.0}[gains.mode], Mixed), {'gains'},
        ('gains', "broken.mode = 'fast'; bound")),
    'fails for a switch': (
        broken(lambda state, seen, gains: [1.0][int(gains.reverse)], Mixed), {'gains'},
        ('gains', 'broken.reverse = True; bound')),
    'cannot prepare gains at a bound': (
        SOUND._replace(name='broken', prepare=unprepared), {'gains'},
        ('gains', 'cannot prepare its gains Gains(k=2.0): ValueError', 'bound the gain')),
    'its repair breaks a rule': (
        PAIR._replace(name='broken', repair=lambda pair: Pair(pair.high, pair.low)), {'repair'},
        ('repair', 'must be below high', 'broken.low = ')),
    'its repair raises': (
        PAIR._replace(name='broken', repair=raising_repair), {'repair'},
        ('repair', 'ArithmeticError: cannot mend', 'low = 1e-09')),
    'fails in the state in which it joins': (
        broken(lambda state, seen, gains: gains.k / (1.0 + state.ticks), Gains, Count(), Count(-1.0)), {'switch'},
        ('switch', 'joining a run: ZeroDivisionError', 'ticks=-1.0')),
    'fails when a gain changes': (
        Law('broken', keeping_step, Gains, Kept()), {'switch'},
        ('switch', 'after a switch, with broken.k = 2e-09: ZeroDivisionError', 'Kept(k=1.0)')),
    'keeps what it has seen in its start': (
        Law('broken', remembering_step, Gains, Memory([0.0])), {'inputs unchanged', 'restart'},
        ('restart', 'keep what changes in the state', 'error=')),
}
