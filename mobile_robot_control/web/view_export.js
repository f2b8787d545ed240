// @ts-check
// What a chart shows now, as a file: a drawing (SVG), or its numbers (CSV).
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const ABOVE = 34, BELOW = 34, LEFT = 70;
  const escape = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const quoted = (text) => /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;

  function save(content, kind, name) {
    const link = mrc.element('a', '', '', {href: URL.createObjectURL(new Blob([content], {type: kind})), download: name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  // Return the numbers of the lines shown, at their times in the range shown.
  function table({view, chart, lines, plot, nameOf}) {
    const shown = lines.map((line, n) => ({line, n: n + 1})).filter(({line}) => view.shows(line));
    const unit = chart.unit ? ` [${chart.unit}]` : '', [times] = plot.data;
    const rows = [['time [s]', ...shown.map(({line}) => quoted(`${chart.label}, ${nameOf(line)}${unit}`))]];
    for (let row = 0; row < times.length; row++) {
      if (times[row] < view.range[0] || times[row] > view.range[1]) continue;
      const values = shown.map(({n}) => plot.data[n][row]);
      if (values.some(Number.isFinite)) {
        rows.push([times[row], ...values].map((value) => Number.isFinite(value) ? String(value) : ''));
      }
    }
    return rows.map((row) => row.join(',')).join('\n') + '\n';
  }

  // Return the chart as it is shown, on light ground.
  function drawing({view, chart, lines, plot, nameOf, strokeOf}) {
    const wide = plot.over.clientWidth, high = plot.over.clientHeight, [width, height] = [wide + LEFT + 16, high + ABOVE + BELOW];
    const parts = [], text = (x, y, words, more = '') => parts.push(`<text x="${x}" y="${y}" ${more}>${escape(words)}</text>`);
    const [across, up] = plot.axes.map((axis) => axis._splits.map((value, n) => [value, axis._values[n]]));
    for (const [value, label] of across) {
      const x = LEFT + plot.valToPos(value, 'x');
      parts.push(`<path d="M${x.toFixed(1)} ${ABOVE}v${high}" stroke="#d8dce1"/>`);
      text(x.toFixed(1), ABOVE + high + 18, String(label), 'text-anchor="middle"');
    }
    for (const [value, label] of up) {
      const y = ABOVE + plot.valToPos(value, 'y');
      parts.push(`<path d="M${LEFT} ${y.toFixed(1)}h${wide}" stroke="#d8dce1"/>`);
      text(LEFT - 6, (y + 4).toFixed(1), String(label), 'text-anchor="end"');
    }
    text(LEFT + wide, height - 2, 't [s]', 'text-anchor="end"');
    text(8, 14, `${chart.label}${chart.unit ? ` [${chart.unit}]` : ''}`, 'font-weight="600"');
    let x = LEFT;
    const told = new Set();
    parts.push(`<clipPath id="plane"><rect x="${LEFT}" y="${ABOVE}" width="${wide}" height="${high}"/></clipPath>`);
    for (const line of lines.filter((one) => view.shows(one))) {
      const {colour, width: thick, dash} = strokeOf(line), stroke = `fill="none" stroke="${colour.light}" `
        + `stroke-width="${thick}" stroke-dasharray="${dash.join(' ')}"`;
      let path = '', joined = false;
      for (let n = 0; n < line.times.length; n++) {
        // one point more at each side: the clip cuts it
        const inside = line.times[n + 1] >= view.range[0] && !(line.times[n - 1] > view.range[1]);
        const edge = n === line.times.length - 1 && line.times[n] >= view.range[0];
        if (!(inside || edge) || !Number.isFinite(line.values[n])) { joined = false; continue; }
        path += `${joined ? 'L' : 'M'}${(LEFT + plot.valToPos(line.times[n], 'x')).toFixed(1)} `
          + (ABOVE + plot.valToPos(line.values[n], 'y')).toFixed(1);
        joined = true;
      }
      parts.push(`<path d="${path}" ${stroke} clip-path="url(#plane)"/>`);
      if (told.has(nameOf(line))) continue;
      told.add(nameOf(line));
      parts.push(`<path d="M${x} 24h24" ${stroke}/>`);
      text(x + 30, 28, nameOf(line));
      x += 46 + 7 * nameOf(line).length;
    }
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" `
      + `font-family="system-ui, sans-serif" font-size="12" fill="#1b1f24"><rect width="${width}" height="${height}" `
      + `fill="#ffffff"/>${parts.join('\n')}</svg>\n`;
  }

  // Return buttons that save what a chart shows: {view, chart, lines, plot, nameOf(line), strokeOf(line)}.
  mrc.viewButtons = function (shown) {
    const box = mrc.element('span', 'save'), {chart, view} = shown;
    const span = () => view.zoomed ? `_${view.range.map((time) => Number(time.toFixed(2))).join('_to_')}_s` : '';
    const name = (kind) => `${chart.figure}_${chart.label.replace(/\W+/g, '_')}${span()}.${kind}`;
    for (const [kind, type, make] of /** @type {[string, string, (shown: any) => string][]} */ ([
      ['svg', 'image/svg+xml', drawing], ['csv', 'text/csv', table]])) {
      const button = mrc.element('button', '', kind.toUpperCase(), {type: 'button', title: 'Save this view'});
      button.setAttribute('aria-label', `Save this view of ${chart.label} as ${kind.toUpperCase()}`);
      button.addEventListener('click', () => save(make(shown), type, name(kind)));
      box.append(button);
    }
    return box;
  };
}(window.mrc));
