"""The figures of the chapter: their numbers, commands and contents; all of them drawn in `make soak`."""

import re
import shlex
from pathlib import Path

import pytest
from chapter_figures import chromosomes, index
from chapter_figures.runs import HYBRID_LEMNISCATE, Runs
from chapter_figures.structure_figures import STRUCTURE_FIGURES, rules
from helpers.harness import CONFIG

from mobile_robot_control.control.hybrid_backstepping import HybridState
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search.space import search_genes
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

RUNS = Runs(CONFIG)


def test_figures_2_to_33_are_there_in_order():
    numbers = [figure.number for figure in index.CHAPTER_FIGURES]
    assert len(set(numbers)) == len(numbers)
    plain = [int(re.match(r'\d+', number).group()) for number in numbers]
    assert plain == sorted(plain)
    assert set(plain) == set(range(2, 34))


@pytest.mark.parametrize('figure', index.CHAPTER_FIGURES, ids=lambda figure: figure.number)
def test_the_command_of_a_figure_has_valid_options_and_files(figure):
    for line in figure.command.splitlines():
        words = shlex.split(line)
        if words[:2] == ['mrc', 'simulate']:
            options = simulate.parser().parse_args(words[2:])
            configure(load([CONFIG.parent / name for name in options.params_files], options.overrides))
        elif words[0] == 'cat':
            assert (CONFIG.parent / words[1]).is_file()
        else:
            assert words[:3] in (['make', 'figures'], ['mrc', 'report', 'run.csv'])


def test_the_ten_rules_are_those_of_the_chapter():
    # section 3.3 of the chapter
    assert rules() == {
        ('S', 'GN'): ('B', 'CW'), ('S', 'SN'): ('F', 'CW'), ('S', 'Z'): ('S', 'ST'), ('S', 'SP'): ('F', 'CCW'),
        ('S', 'GP'): ('B', 'CCW'), ('G', 'GN'): ('FB', 'CW'), ('G', 'SN'): ('FF', 'CW'), ('G', 'Z'): ('FF', 'ST'),
        ('G', 'SP'): ('FF', 'CCW'), ('G', 'GP'): ('FB', 'CCW'),
    }


@pytest.mark.parametrize('figure', STRUCTURE_FIGURES, ids=lambda figure: figure.number)
def test_a_figure_is_drawn(figure):
    assert figure.draw(RUNS).axes


def test_the_chromosomes_have_the_chapters_genes_and_values():
    # section 3.1 of the chapter
    found = {gene.symbol: gene.value for gene in chromosomes.backstepping_genes(RUNS)}
    assert found == {'p': 1.9934, 'q': 0.0530, 'f': 9.8615, 'g': 2.9956, 'K1': 128.444, 'Ti1': 60.9756, 'K2': 29.048,
                     'Ti2': 31.4465}
    assert [gene.symbol for gene in chromosomes.fuzzy_genes(RUNS)] == [
        'a1', 'b1', 'b2', 'b3', 'b4', 'b5', 'b6', 'c1', 'c2', 'c3', 'c4', 'c5', 'd1', 'd2', 'd3']


def test_the_chromosomes_have_the_bounds_of_the_search():
    for genes, search in ((chromosomes.backstepping_genes(RUNS), 'backstepping'),
                          (chromosomes.fuzzy_genes(RUNS), 'fuzzy')):
        assert [gene.bounds for gene in genes] == [
            f'{gene.low:.3g} to {gene.high:.3g}' for gene in search_genes(search)[:len(genes)]]


def test_the_velocity_loop_follows_a_step():
    ticks = list(RUNS.velocity_steps(((0.01, BodyVelocity(1.0, 0.0)),), 0.05))
    assert ticks[0].velocity == BodyVelocity(0.0, 0.0)
    assert ticks[-1].velocity.linear == pytest.approx(1.0, abs=0.01)
    assert ticks[-1].velocity.angular == pytest.approx(0.0, abs=1e-9)


def test_the_states_of_the_seeking_are_those_of_the_law():
    ticks = list(RUNS.seeking(HYBRID_LEMNISCATE, 0.1))
    assert ticks[0][1] == HybridState()
    for sample, state in ticks:
        # before the cart is in sight the command is the seeking rotation itself
        assert state.seen == 0.0
        assert sample.command == BodyVelocity(0.0, state.seek)


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_the_index_page_shows_every_figure_on_phone_and_desktop(browser, tmp_path):
    page = index.write_index(CONFIG, tmp_path / 'figures')
    for figure in index.CHAPTER_FIGURES:
        assert (page.parent / f'figure_{figure.number}.png').stat().st_size > 3000
    for width in (360, 1280):
        browser.show(Path(page), width)
        assert browser.evaluate('document.images.length') == len(index.CHAPTER_FIGURES)
        assert browser.evaluate('[...document.images].every(image => image.complete && image.naturalWidth > 0)')
        assert browser.evaluate('document.documentElement.scrollWidth <= innerWidth')
