"""Chromosomes and what they encode: always a valid controller, within its bounds."""

import math
from itertools import groupby

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.control.fuzzy import FuzzyGains, repair
from mobile_robot_control.control.laws import LAWS, PositionControl
from mobile_robot_control.parameters.declaration import ParameterError, build, flatten
from mobile_robot_control.search import genetic, space
from mobile_robot_control.search.gains import configured_gains
from mobile_robot_control.search.space import (
    SEARCHES,
    at_the_edge,
    bounded,
    decode,
    population_of,
    search_genes,
    widened,
    without,
)
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import Configuration

START = configured_gains(Configuration())


def test_twelve_bits_encode_4096_evenly_spaced_points():
    numbers = np.arange(4096)
    bits = ((numbers[:, None] >> np.arange(11, -1, -1)) & 1).astype(bool)
    points = genetic.points(bits)
    assert points.shape == (4096, 1)
    assert np.array_equal(points[:, 0], (numbers + 1) / 4096)


def test_genes_and_populations_are_those_of_the_chapter():
    assert [gene.short for gene in search_genes('backstepping')] == ['p', 'q', 'f', 'g', 'k1', 'ti1', 'k2', 'ti2']
    assert [gene.short for gene in search_genes('fuzzy')] == [
        'a', 'b1', 'b2', 'b3', 'b4', 'b5', 'b6', 'c1', 'c2', 'c3', 'c4', 'c5', 'd1', 'd2', 'd3']
    assert (population_of('backstepping'), population_of('fuzzy')) == (51, 101)


@settings(max_examples=100)
@given(st.sampled_from(list(SEARCHES)), st.data())
def test_every_chromosome_decodes_to_a_valid_controller_within_bounds(controller, data):
    genes = search_genes(controller)
    numbers = data.draw(st.lists(st.integers(1, 4096), min_size=len(genes), max_size=len(genes))
                        | st.sampled_from([[1] * len(genes), [4096] * len(genes)]))
    found = decode(genes, [number / 4096 for number in numbers], START)
    # the check of the node
    assert build(PositionControl, flatten(found.control)) == found.control
    assert min(found.velocity.gains) > 0.0
    searched = {name.rpartition('.')[2]: value for parameters in space.parameters(genes, found).values()
                for name, value in parameters.items()}
    # b1 to b6 are the array b, whose numbers are exchanged until they are in order
    for name, group in groupby(genes, lambda gene: gene.name.rpartition('.')[2].partition('[')[0]):
        bounds, value = list(group), searched.pop(name)
        decoded = value if isinstance(value, tuple) else (value,)
        assert len(decoded) == len(bounds)
        assert min(gene.low for gene in bounds) < min(decoded)
        assert max(decoded) <= max(gene.high for gene in bounds)
    assert set(searched) <= {
            'controller_type', 'alpha', 'xi_min', 'softening', 'max_steer', 'least_lookahead', 'radius'}


def test_corners_in_order_stay_and_others_are_exchanged():
    good = (1.2, 0.5, 0.9, 1.1, 0.1, 0.6)
    # b3 and b4 exchanged, b1 below b2, b5 above b6
    for corners, repaired in ((good, good), ((0.5, 1.2, 1.1, 0.9, 0.6, 0.1), (0.9, 0.5, 1.1, 1.2, 0.1, 0.6))):
        assert repair(FuzzyGains(b=corners)).b == repaired
    b1, b2, b3, b4, b5, b6 = repair(FuzzyGains(b=(math.pi,) * 6)).b
    assert b2 < b3 < b4 <= math.pi
    assert b2 < b1 <= math.pi
    assert b5 < b4
    assert b5 < b6 <= math.pi


def test_a_velocity_search_keeps_the_law_and_a_fuzzy_search_the_velocity_gains():
    velocity = decode(search_genes('velocity'), [0.5] * 4, START)
    assert velocity.velocity.gains == (10.0, 30.0, 10.0, 30.0)
    assert velocity.control == START.control
    fuzzy = decode(search_genes('fuzzy'), [0.5] * 15, START)
    assert fuzzy.velocity == START.velocity
    assert fuzzy.control.fuzzy != START.control.fuzzy


def test_searched_gains_have_the_names_of_the_parameter_file():
    found = decode(search_genes('backstepping'), [0.25] * 8, START)
    named = space.parameters(search_genes('backstepping'), found)
    assert named['velocity_controller'] == {'gains.k1': 5.0, 'gains.ti1': 15.0, 'gains.k2': 5.0, 'gains.ti2': 15.0}
    assert named['position_controller'] == {
        'controller_type': 'backstepping', 'backstepping.p': 1.25, 'backstepping.q': 0.5, 'backstepping.alpha': 1.0,
        'backstepping.f': 5.0, 'backstepping.g': 5.0}
    assert configure({'position_controller': named['position_controller']})


def test_given_bounds_are_used_and_checked():
    genes = bounded(search_genes('backstepping'), {'k1': (1.0, 2.0)})
    found = decode(genes, [1.0] * 8, START)
    assert found.velocity.gains.k1 == 2.0
    with pytest.raises(ParameterError) as refused:
        bounded(search_genes('fuzzy'), {'k1': (0.0, 1.0), 'a': (-1.0, 1.0), 'b2': (0.0, 4.0), 'c1': (1.0, 0.0)})
    assert len(refused.value.violations) == 4
    assert 'k1' in str(refused.value)


def test_a_search_leaves_alone_what_it_is_told_to_keep():
    genes = without(search_genes('fuzzy', with_velocity=True), ['b', 'c5', 'gains.k1'])
    assert [gene.short for gene in genes] == ['a', 'c1', 'c2', 'c3', 'c4', 'd1', 'd2', 'd3', 'ti1', 'k2', 'ti2']
    found = decode(genes, [0.5] * len(genes), START)
    assert found.control.fuzzy.b == START.control.fuzzy.b
    assert found.control.fuzzy.c[4] == START.control.fuzzy.c[4]
    assert found.velocity.gains.k1 == START.velocity.gains.k1
    assert found.control.fuzzy.a == 0.5


def test_a_repair_that_returns_no_gains_is_refused_by_its_law(registered):
    LAWS.register(LAWS['fuzzy']._replace(name='forgetful', repair=lambda drawn: None))
    genes = search_genes('forgetful')
    with pytest.raises(ParameterError, match="repair of the law 'forgetful' returns None, and must return gains of F"):
        decode(genes, [0.5] * len(genes), START)


def test_gains_that_break_a_rule_around_a_kept_one_are_named():
    genes = without(search_genes('fuzzy'), ['b4'])
    # the third corner is drawn beyond the fourth, which stays
    beyond = decode(bounded(genes, {'b3': (2.9, 3.0)}), [0.5] * len(genes), START)
    assert beyond.control.fuzzy.b[3] == START.control.fuzzy.b[3]
    assert 'b2 < b3 < b4' in space.violations(genes, beyond)[0]
    assert not space.violations(genes, START)


def test_gains_at_an_edge_beyond_which_the_law_allows_more_are_named():
    genes = bounded(search_genes('backstepping'), {'p': (0.0, 2.0), 'q': (1.0, 2.0)})
    inside = [0.5] * len(genes)
    assert list(at_the_edge(genes, inside)) == []
    assert list(at_the_edge(genes, [0.999, *inside[1:]])) == [
        'position_controller.backstepping.p is at the upper edge of its search, 0 to 2']
    # no other gain may be negative
    assert list(at_the_edge(genes, [0.001] * len(genes))) == [
        'position_controller.backstepping.q is at the lower edge of its search, 1 to 2']


def test_a_bound_that_the_best_gains_reach_is_doubled_or_halved_as_far_as_the_law_allows():
    # a weight lies between 1e-3 and 1e6
    genes = bounded(search_genes('lqr'), {'q1': (1.0, 7e5), 'q2': (0.5, 9.0), 'q3': (4.0, 5.0)})
    assert [(gene.low, gene.high) for gene in widened(genes[:3], [1.0, 0.001, 0.995])] == [
        (1.0, 1e6), (0.25, 9.0), (4.0, 10.0)]
    assert widened(genes[:3], [0.5] * 3) == genes[:3]
    assert widened(genes[:3], [1.0, 0.001, 0.5], {genes[0].name, genes[1].name}) == genes[:3]
    # 0.01 of this width is not near its lower bound
    wide = bounded(search_genes('lqr'), {'q2': (0.5, 1e4)})
    assert widened(wide, [0.5, 0.005, *[0.5] * 5]) == wide
    # outputs of either sign: -12 to 0, -0.5 to 0.5, 0 to 12
    turns = [gene for gene in search_genes('fuzzy') if '.d[' in gene.name]
    assert [(gene.low, gene.high) for gene in widened(turns, [0.001, 0.001, 0.001])] == [
        (-24.0, 0.0), (-1.0, 0.5), (-12.0, 12.0)]
    assert [gene.high for gene in widened(turns, [1.0, 1.0, 1.0])] == [12.0, 1.0, 24.0]


def test_a_gene_is_named_by_its_parameter_or_an_end_of_that():
    genes = search_genes('fuzzy', with_velocity=True)
    assert [gene.name for gene in (genes[0], genes[-1])] == [
        'position_controller.fuzzy.a', 'velocity_controller.gains.ti2']
    for name in ('b1', 'b[1]', 'fuzzy.b[1]', 'position_controller.fuzzy.b[1]'):
        found = {gene.name: gene for gene in bounded(genes, {name: (0.5, 1.5)})}
        assert found['position_controller.fuzzy.b[1]'][1:] == (0.5, 1.5)
    assert [gene[1:] for gene in bounded(genes, {'fuzzy.b': (0.5, 1.5)}) if '.b[' in gene.name] == [(0.5, 1.5)] * 6
    lags = bounded(space.feedforward_genes(['feedforward.lag']), {'feedforward.lag': (0.0, 0.6)})
    assert lags == tuple((f'position_controller.feedforward.lag[{n}]', 0.0, 0.6) for n in (1, 2))
    with pytest.raises(ParameterError, match="no gene 'k3' here; did you mean 'k"):
        without(genes, ['k3'])
