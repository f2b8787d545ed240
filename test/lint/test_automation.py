"""CI runs the README's commands, the hooks run what the lint tests run, the citation has the present version."""

import re
from pathlib import Path

import yaml

from mobile_robot_control import __version__

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / 'Makefile').read_text(encoding='utf-8')


def _load(name):
    return yaml.safe_load((ROOT / name).read_text(encoding='utf-8'))


def _runs(job):
    return [step['run'] for step in job['steps'] if 'run' in step]


def test_ci_runs_both_commands_of_the_readme_on_both_distributions():
    jobs = _load('.github/workflows/ci.yml')['jobs']
    matrix = jobs['test']['strategy']['matrix']
    assert matrix == {'ros': ['kilted', 'jazzy'], 'python': ['3.10', '3.12']}
    for distribution in matrix['ros']:
        assert re.search(rf'\bfilter-out .*\b{distribution}\b', MAKEFILE), distribution
    assert _runs(jobs['test']) == [f'make {target} ROS=${{{{ matrix.ros }}}}' for target in ('demo', 'test')]
    readme = (ROOT / 'README.md').read_text(encoding='utf-8')
    assert 'make demo ' in readme
    assert 'make test ' in readme


def test_every_job_checks_the_repository_out_and_sets_its_language_up_before_it_runs_a_target_that_exists():
    workflow = _load('.github/workflows/ci.yml')
    # YAML 1.1 reads the key on as true
    assert {'push', 'pull_request'} <= set(workflow[True])
    for name, job in workflow['jobs'].items():
        assert job['runs-on'].startswith('ubuntu-')
        used = [step['uses'].partition('@')[0] for step in job['steps'] if 'uses' in step]
        assert used[0] == 'actions/checkout', name
        assert used[1] in ('actions/setup-python', 'actions/setup-node'), name
        first = next(n for n, step in enumerate(job['steps']) if 'run' in step)
        assert first >= 2
        for command in _runs(job):
            assert re.search(rf'^{command.split()[1]}:', MAKEFILE, re.MULTILINE), command


def test_every_pin_of_the_package_is_locked_for_both_distributions_and_every_python():
    pins = set(re.findall(r"'([\w.-]+)(?:\[\w+\])?==([\w.]+)'", (ROOT / 'setup.py').read_text(encoding='utf-8')))
    locked = sorted((ROOT / 'constraints').iterdir())
    assert len(locked) == 8
    for file in locked:
        other = {'jazzy': 'ros-kilted', 'kilted': 'ros-jazzy'}[file.name.partition('-')[0]]
        versions = set(re.findall('^(.+)==(.+)$', file.read_text(encoding='utf-8').lower(), re.MULTILINE))
        missing = {pin for pin in pins if (pin[0].lower(), pin[1]) not in versions and not pin[0].startswith(other)}
        assert not missing, f'{file.name} lacks {missing}: make constraints'


def test_the_hooks_run_what_the_lint_tests_run():
    tests = (ROOT / 'test' / 'lint' / 'test_style.py').read_text(encoding='utf-8')
    hooks = [hook for repository in _load('.pre-commit-config.yaml')['repos'] for hook in repository['hooks']]
    assert {hook['id'] for hook in hooks} == {'ruff', 'mypy'}
    for hook in hooks:
        python, module, *words = hook['entry'].split()
        assert (python, module) == ('.venv/bin/python', '-m')
        assert all(f"'{word}'" in tests for word in words), hook['entry']
    assert not any(hook['pass_filenames'] for hook in hooks)


def test_the_citation_has_the_present_version_and_licence():
    citation = _load('CITATION.cff')
    assert citation['cff-version'] == '1.2.0'
    assert citation['version'] == __version__
    assert {'message', 'title', 'authors'} <= set(citation)
    assert f"license='{citation['license']}'" in (ROOT / 'setup.py').read_text(encoding='utf-8')
    released = re.search(rf'^{re.escape(__version__)} \((.+)\)$', (ROOT / 'CHANGELOG.rst').read_text(), re.MULTILINE)
    assert str(citation['date-released']) == released.group(1)
