"""HTML pages: one self-contained file each, light or dark, for phone, desktop and paper."""

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import ArrayLike


def pack(values: ArrayLike) -> str:
    """
    Return numbers as base64 of 32-bit floats, little-endian; nan stays nan.

    A number keeps seven digits, and a time of ten minutes 0.03 ms: enough for a picture, not for a table.
    """
    return base64.b64encode(np.ascontiguousarray(values, dtype='<f4').tobytes()).decode()


_WEB = Path(__file__).parents[1] / 'web'


def asset(name: str) -> str:
    """Return a file of this folder, such as 'clock.js' or 'uplot/uPlot.min.css', a script without its comment lines."""
    text = (_WEB / name).read_text(encoding='utf-8')
    return re.sub(r'^ *//.*\n', '', text, flags=re.MULTILINE) if name.endswith('.js') else text


_PLAIN = " !$&'()*+,-./:;<=>?@[]^_`{|}~"
"""Characters allowed unescaped in a data URI, beside letters and digits."""
_COLOURS = asset('colours.css')
_STYLE = """
*{box-sizing:border-box}
body{margin:0 auto;max-width:75rem;padding:1rem;background:var(--ground);color:var(--ink);
font:16px/1.5 system-ui,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;overflow-wrap:break-word}
h1{font-size:1.5rem;line-height:1.25;margin:.5rem 0}h2{font-size:1.15rem;margin:2rem 0 .5rem}
h3{font-size:1rem;margin:0 0 .25rem}p{margin:.25rem 0 .75rem}
.soft,figcaption{color:var(--soft);font-size:.9rem}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,34rem),1fr));gap:1.5rem;align-items:start}
figure{margin:0;min-width:0}figure img{display:block;width:100%;height:auto}
.still img{min-width:34rem}
.scroll{overflow-x:auto;max-width:100%}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.9rem}
th,td{text-align:left;padding:.3rem .7rem .3rem 0;border-bottom:1px solid var(--faint);vertical-align:top}
@media screen and (min-width:60rem){#metrics>.scroll:not(:has(th:nth-child(4))){columns:30rem}
#metrics th.number{max-width:9rem}}
@media screen and (max-width:39.99rem){#metrics table{font-size:.8rem}#metrics td.number{padding-left:.3rem}}
td.number,th.number{text-align:right;padding-left:.7rem;padding-right:0}td.number{white-space:nowrap}
th.number{max-width:16rem;min-width:6rem}
.change{display:block;color:var(--soft);font-size:.8rem}data{cursor:help}
.best{color:var(--best);font-weight:700}
.warning{border-left:4px solid var(--warn);padding:.1rem 0 .1rem .8rem}.warning h2{margin-top:.2rem}
code{background:var(--tint);padding:.1em .3em;border-radius:3px;font-size:.9em;overflow-wrap:anywhere}
pre{background:var(--tint);padding:.7rem;border-radius:4px;overflow-x:auto;font-size:.85rem;margin:.5rem 0}
pre code{background:none;padding:0;overflow-wrap:normal}
.command{white-space:pre-wrap}.command code{overflow-wrap:anywhere}
.live:not(.charted){display:none}
summary{cursor:pointer}
a{color:inherit}
.contents ul{list-style:none;margin:.5rem 0;padding:0;font-size:.9rem}.contents li{margin:.15rem 0}
.contents a{display:inline-block;margin-right:.8rem}.contents span a{color:var(--soft)}
@media print{body{max-width:none;font-size:10pt;padding:0}
.grid{grid-template-columns:1fr;gap:.5cm}.still img{min-width:0;width:14.5cm}
figure,tr,.warning{break-inside:avoid}.contents,.live{display:none}h2{break-after:avoid}.scroll{overflow:visible}
table{width:100%;font-size:8pt}th,td{overflow-wrap:anywhere}td.number{white-space:normal}th.number{min-width:0}
details::details-content{content-visibility:visible;display:block;height:auto}}
"""


def page(title: str, parts: Iterable[str], styles: Iterable[str] = (), scripts: Iterable[str] = ()) -> str:
    """
    Return a page that loads nothing else, and is forbidden to.

    Parameters
    ----------
    title : str
        Plain text.
    parts : iterable of str
        HTML, from top to bottom.
    styles, scripts : iterable of str
        More style sheets, and scripts to run after the page has been read: no other script runs, wherever it comes
        from.
    """
    texts = [f'\n{script}\n' for script in scripts]
    body = '\n'.join([*parts, *(f'<script>{text}</script>' for text in texts)])
    style = '\n'.join([_COLOURS, _STYLE, *styles])
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{_policy(texts)}">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n</body>\n'
            '</html>\n')


def contents(sections: Iterable[tuple[str, str, Sequence[tuple[str, str]]]]) -> str:
    """Return a list of jumps: the id and the title of each section, and those of its parts; as HTML."""
    def jump(name: str, title: str) -> str:
        return f'<a href="#{escape(name)}">{escape(title)}</a>'

    items = ''.join(f'<li>{jump(name, title)} <span>{" ".join(jump(*inner) for inner in within)}</span></li>'
                    for name, title, within in sections)
    return f'<nav class="contents" aria-label="On this page"><ul>{items}</ul></nav>'


def _policy(scripts: Sequence[str]) -> str:
    """Return the content security policy of a page with these scripts: it fetches nothing, and runs no other."""
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in scripts]
    allowed = ' '.join(f"'sha256-{text}'" for text in hashes) or "'none'"
    return (f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
            "form-action 'none'")


def json_block(name: str, value: object) -> str:
    """Return a value as an element of a page, with an id, for scripts; none of its texts can end the element."""
    text = json.dumps(value, separators=(',', ':'), allow_nan=False).replace('<', '\\u003c')
    return f'<script type="application/json" id="{escape(name)}">{text}</script>'


def source(content: bytes, kind: str) -> str:
    """Return the content of a picture's file as a data URI of a media type such as 'image/gif'."""
    return f'data:{kind};base64,{base64.b64encode(content).decode()}'


def drawing(svg: str) -> str:
    """Return an SVG as a data URI for an attribute in double quotes, as its text: a quarter shorter than in base64."""
    # either kind of quotes serves in SVG; browsers ignore line breaks
    text = ' '.join(svg.split()).replace("'", '&apos;').replace('"', "'").replace('> <', '><')
    return f'data:image/svg+xml,{quote(text, _PLAIN)}'.replace('&', '&amp;')


def picture(title: str, caption: str, image: str, below: str = '', name: str = '') -> str:
    """
    Return a figure as HTML.

    Parameters
    ----------
    title, caption : str
        Plain text.
    image : str
        Data URI of the picture.
    below : str
        HTML under the caption.
    name : str
        Id of the figure, and of its charts, if the page has any.
    """
    place = f' id="{escape(name)}"' if name else ''
    charts = f'<div class="charts" data-figure="{escape(name)}"></div>' if name else ''
    return (f'<figure{place}><h3>{escape(title)}</h3><div class="scroll still" tabindex="0">'
            f'<img src="{image}" alt="{escape(title)}: {escape(caption)}"></div>'
            f'{charts}<figcaption>{escape(caption)}{below}</figcaption></figure>')


def live(title: str, caption: str, name: str) -> str:
    """Return the place of charts without a picture, as HTML: a title, a caption in plain text, and their name."""
    return (f'<figure class="live" id="{escape(name)}"><h3>{escape(title)}</h3>'
            f'<div class="charts" data-figure="{escape(name)}"></div>'
            f'<figcaption>{escape(caption)}</figcaption></figure>')


def section(name: str, title: str, *parts: str) -> str:
    """Return a section with an id, a heading in plain text and its parts in HTML."""
    return '\n'.join([f'<section id="{escape(name)}">', f'<h2>{escape(title)}</h2>', *parts, '</section>'])


def grid(figures: Iterable[str]) -> str:
    """Return figures side by side, as many as the page has room for; all HTML."""
    return '<div class="grid">\n' + '\n'.join(figures) + '\n</div>'


def html_table(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = True) -> str:
    """
    Return a table as HTML, with its own scroll bar if it is wider than the page.

    Parameters
    ----------
    head : sequence of str
        Plain text.
    rows : iterable of sequence of str
        Cells in HTML.
    numbers : bool
        Whether all columns but the first contain numbers.
    """
    def cells(kind: str, row: Iterable[str]) -> str:
        kinds = ((kind if cell else 'td', cell) for cell in row)  # an empty head says nothing
        return ''.join(f'<{kind}{" class=number" if numbers and n else ""}>{cell}</{kind}>'
                       for n, (kind, cell) in enumerate(kinds))

    body = '\n'.join(f'<tr>{cells("td", row)}</tr>' for row in rows)
    return (f'<div class="scroll" tabindex="0"><table><thead><tr>{cells("th", map(breakable, head))}</tr></thead>\n'
            f'<tbody>\n{body}\n</tbody></table></div>')


def breakable(name: str) -> str:
    """Return a name as HTML that breaks lines after underscores, and not within a word."""
    return escape(name).replace('_', '_<wbr>')


def warning(title: str, sentences: Iterable[str]) -> str:
    """Return a highlighted list of sentences under a title, as HTML; all arguments are plain text."""
    items = ''.join(f'<li>{escape(sentence)}</li>' for sentence in sentences)
    return f'<div class="warning"><h2>{escape(title)}</h2><ul>{items}</ul></div>'


def made_with(
    origin: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Mapping[str, Any]]] | None = None
) -> str:
    """
    Return the origin of a page's numbers, folded, as HTML.

    Parameters
    ----------
    origin : mapping of str to object
        Result of `provenance`.
    parameters : mapping of str to mapping, or None
        By controller, for a page without a table of them.
    """
    versions = ', '.join(f'{name} {version}' for name, version in origin['versions'].items() if version)
    listed = ''.join(f'<h3>{escape(name)}</h3><pre tabindex="0"><code>{escape(_lines(one))}</code></pre>'
                     for name, one in (parameters or {}).items())
    return (f'<details class="made"><summary>How this was made</summary><pre class="command"><code>'
            f'{escape(origin["command_line"])}</code></pre><p>{escape(versions)}</p>{listed}</details>')


def _lines(parameters: Mapping[str, Mapping[str, object]]) -> str:
    return '\n'.join(f'{node}.{name}: {json.dumps(value)}' for node, values in parameters.items()
                     for name, value in values.items())
