"""The documentation as a site: `make docs` renders these pages and the docstrings of the public API."""

import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math import latex2mathml

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(1, str(Path(__file__).parents[1] / 'tools'))

from notebook_page import markdown_of

from mobile_robot_control.parameters.declaration import Field, members
from mobile_robot_control.version import __version__

ROOT = Path(__file__).parents[1]

project = 'mobile_robot_control'
author = 'mobile_robot_control maintainers'
copyright = f'2026, {author}'
release = __version__

extensions = ['myst_parser', 'sphinx.ext.autodoc', 'numpydoc']
exclude_patterns = ['_build']
# links to headings, named as GitHub names them
myst_heading_anchors = 4
myst_enable_extensions = ['dollarmath']
# formulas that browsers draw themselves: no script, and nothing from a network
html_math_renderer = 'mathml'

add_module_names = False
autodoc_member_order = 'bysource'
autodoc_default_options = {'members': True, 'special-members': '__call__'}
# the docstrings name the types, with units and shapes
autodoc_typehints = 'none'
numpydoc_show_class_members = False

html_static_path = ['_static']
html_css_files = ['site.css']
html_theme = 'furo'
html_title = f'{project.replace("_", " ")} {release}'
html_show_sphinx = False
html_copy_source = False
# excerpts are fetched, which browsers forbid to a site that is opened from a disk
html_show_search_summary = False


def _declared(group):
    """Return the parameters that a NamedTuple declares as the lines of a numpydoc section."""
    for name, kind, annotation in members(group):
        if isinstance(annotation, Field):
            unit = f' [{annotation.unit}]' if annotation.unit else ''
            yield from (f'{name} : {kind.__name__}', f'    {annotation.description}{unit}.')


def _complete(_app, what, _name, thing, _options, lines):
    """Add what a class declares; keep |x|, an absolute value, from being read as a substitution."""
    declared = list(_declared(thing)) if what == 'class' and hasattr(thing, '_fields') else []
    if declared:
        lines += ['', 'Attributes', '----------', *declared, '']
    lines[:] = [line.replace('|', r'\|') for line in lines]


def _is_field_alias(_app, _what, _name, thing, _skip, _options):
    """Leave out the fields of a NamedTuple one by one: its docstring has them with their units."""
    return True if type(thing).__name__ == '_tuplegetter' else None


def _insert_notebook(app, name, source):
    """Put the notebook, with its outputs, where the page of the tutorial has its mark."""
    if name == 'tutorial':
        notebook = ROOT / 'examples' / 'tutorial' / 'trajectory_tracking.ipynb'
        app.env.note_dependency(str(notebook))
        source[0] = source[0].replace('<!-- the notebook -->', markdown_of(notebook))


def _inline_formula(translator, node):
    translator.body.append(latex2mathml.tex2mathml(node.astext()))
    raise nodes.SkipNode


def _formula(translator, node):
    translator.body.append(f'<div class="math">{latex2mathml.tex2mathml(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app):
    """Connect the handlers, the first before numpydoc reads the docstrings."""
    app.add_html_math_renderer('mathml', (_inline_formula, None), (_formula, None))
    app.connect('source-read', _insert_notebook)
    app.connect('autodoc-process-docstring', _complete, priority=1)
    app.connect('autodoc-skip-member', _is_field_alias)
