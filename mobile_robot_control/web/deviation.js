// @ts-check
// The path of each run beside that of the cart, with the error enlarged by a factor that a slider sets.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const SHARE = 0.12, MOST = 1000;  // of the path's size that the larger errors take by default, and largest factor
  const STEPS = [1, 2, 5, 10, 20, 50, 100, 200, 500, MOST];

  function bounds(values) {
    let low = Infinity, high = -Infinity;
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [low, high];
  }

  // Return the largest of the STEPS at which 90 % of the errors take at most a share of the path's size.
  function defaultFactor(parts) {
    const sizes = [], errors = [];
    for (const part of parts) {
      const [left, right] = bounds(part.x), [low, high] = bounds(part.y);
      sizes.push(Math.max(right - left, high - low));
      const found = Array.from(part.x_error, (x, n) => Math.hypot(x, part.y_error[n])).filter(Number.isFinite).sort(
        (a, b) => a - b);
      errors.push(found[Math.floor(0.9 * (found.length - 1))] || 0);
    }
    // by the run in the middle: smaller errors are seen still, and larger ones are not all over the place
    const middle = errors.sort((a, b) => a - b)[errors.length >> 1];
    const fits = SHARE * Math.max(...sizes) / Math.max(middle, 1e-9);
    return STEPS.filter((step) => step <= fits).pop() || 1;
  }

  mrc.drawDeviation = function (view, host) {
    const {data} = view, parts = data.deviation.map(({run, time, x, y, x_error, y_error}) => ({
      run, time: data.columns[time], x: data.columns[x], y: data.columns[y], x_error: data.columns[x_error],
      y_error: data.columns[y_error]}));
    const box = mrc.element('div', 'chart deviation'), canvas = mrc.element('canvas'), head = mrc.element('div', 'head');
    const slider = mrc.element('input', '', '', {type: 'range', min: 0, max: STEPS.length - 1, step: 1,
                                                 value: STEPS.indexOf(defaultFactor(parts))}), shown = mrc.element('output'), label = mrc.element('label', 'factor', 'error × ');
    label.append(slider, shown);
    const legend = mrc.element('div', 'legend'), values = [];
    parts.forEach((part) => {
      const run = data.runs[part.run], name = view.several ? run.name : 'distance';
      if (!view.several) { values.push({part, value: legend.appendChild(mrc.element('span', 'value'))}); return; }
      const entry = mrc.switchOf(view, `run ${part.run}`, name, mrc.strokeOf(run));
      values.push({part, value: entry.value});
      legend.append(entry.button);
    });
    head.append(mrc.element('h4', '', 'Path, the error enlarged'), label, legend);
    box.append(head, canvas, mrc.element('p', 'soft', 'Each robot is drawn beside the cart by its error times the '
      + 'factor, for the time that the charts show; with 1 it is the path itself. The axes are those of the cart. Dots are where cart and robot are now.'));
    host.append(box);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', 'Path of the cart, and beside it each run, the error times the factor');
    const factor = () => STEPS[slider.value];
    let map = null;

    // Return the first and the last place of a run's times within the range shown.
    const within = (part) => [mrc.indexAt(part.time, view.range[0]), mrc.indexAt(part.time, view.range[1])];

    function fit(width, height, chosen) {
      const box = [Infinity, -Infinity, Infinity, -Infinity];
      for (const {part, from, to} of chosen) {
        // the enlarged errors are in sight but for the farthest, which would make all else small
        for (let n = from; n <= to; n++) {
          if (!Number.isFinite(part.x[n] + part.y[n])) continue;
          box[0] = Math.min(box[0], part.x[n]); box[1] = Math.max(box[1], part.x[n]);
          box[2] = Math.min(box[2], part.y[n]); box[3] = Math.max(box[3], part.y[n]);
        }
      }
      const size = Math.max(box[1] - box[0], box[3] - box[2], 1e-3), margin = 0.22 * size;
      const scale = Math.min(width / (box[1] - box[0] + 2 * margin), height / (box[3] - box[2] + 2 * margin));
      const [x, y] = [(box[0] + box[1]) / 2, (box[2] + box[3]) / 2];
      return {place: (px, py) => [width / 2 + (px - x) * scale, height / 2 - (py - y) * scale], scale,
              left: x - width / 2 / scale, right: x + width / 2 / scale,
              low: y - height / 2 / scale, top: y + height / 2 / scale};
    }

    // Draw grid lines, with the coordinates of the cart along the left and lower edge.
    function grid(pen, width, height, {place, scale, left, right, low, top}) {
      const step = mrc.roundStep(70 / scale), label = (value) => mrc.number(value, '', 8);
      pen.lineWidth = 1;
      pen.font = '12px system-ui, sans-serif';
      pen.strokeStyle = mrc.colour('--faint');
      pen.fillStyle = mrc.colour('--soft');
      for (let n = Math.ceil(left / step); n * step <= right; n++) {
        const px = Math.round(place(n * step, 0)[0]) + 0.5;
        pen.strokeRect(px, 0, 0, height);
        if (px > 40 && px < width - 70) pen.fillText(label(n * step), px + 3, height - 4);
      }
      for (let n = Math.ceil(low / step); n * step <= top; n++) {
        const py = Math.round(place(0, n * step)[1]) + 0.5;
        pen.strokeRect(0, py, width, 0);
        if (py > 30 && py < height - 20) pen.fillText(label(n * step), 3, py - 3);
      }
      pen.fillText('y [m]', 3, 12);
      pen.textAlign = 'right';
      pen.fillText('x [m]', width - 3, height - 4);
      pen.textAlign = 'left';
    }

    function trace(pen, {part, from, to}, times, style) {
      pen.beginPath();
      let joined = false;
      for (let n = from; n <= to; n++) {
        const x = part.x[n] + times * part.x_error[n], y = part.y[n] + times * part.y_error[n];
        if (!Number.isFinite(x + y)) { joined = false; continue; }
        const [px, py] = map(x, y);
        if (joined) pen.lineTo(px, py); else pen.moveTo(px, py);
        joined = true;
      }
      pen.setLineDash(style.dash);
      pen.lineWidth = style.width;
      pen.strokeStyle = mrc.look(style.colour);
      pen.stroke();
      pen.setLineDash([]);
    }

    function dot(pen, place, colour) {
      pen.beginPath();
      pen.arc(place[0], place[1], 4.5, 0, 2 * Math.PI);
      pen.fillStyle = colour;
      pen.fill();
    }

    function draw() {
      const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
      if (!width || !height) return;
      if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
      if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
      const pen = canvas.getContext('2d'), chosen = parts.map((part) => {
        const [from, to] = within(part);
        return {part, from, to};
      });
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.clearRect(0, 0, width, height);
      const fitted = fit(width, height, chosen);
      map = fitted.place;
      grid(pen, width, height, fitted);
      chosen.forEach((one) => trace(pen, one, 0, {colour: data.reference, width: data.runs[0].width + 2, dash: []}));
      const lit = chosen.filter(({part}) => !view.off.has(`run ${part.run}`));
      for (const one of lit) {
        const run = data.runs[one.part.run];
        trace(pen, one, factor(), mrc.strokeOf(run));
      }
      for (const {part} of lit) {
        const n = mrc.nearest(part.time, view.time());
        if (n < 0) continue;
        const cart = map(part.x[n], part.y[n]);
        const robot = map(part.x[n] + factor() * part.x_error[n], part.y[n] + factor() * part.y_error[n]);
        pen.beginPath();
        pen.moveTo(cart[0], cart[1]);
        pen.lineTo(robot[0], robot[1]);
        pen.lineWidth = 1;
        pen.strokeStyle = mrc.look(data.command);
        pen.stroke();
        dot(pen, cart, mrc.look(data.reference));
        dot(pen, robot, mrc.look(data.runs[part.run]));
      }
    }

    function update() {
      for (const {part, value} of values) {
        const n = mrc.nearest(part.time, view.time());
        const far = n < 0 ? NaN : 100 * Math.hypot(part.x_error[n], part.y_error[n]);
        value.textContent = `${view.several ? '' : 'distance '}${mrc.number(far, 'cm')}`;
      }
      shown.textContent = `${factor()}`;
      slider.setAttribute('aria-valuetext', `${factor()} times`);
    }

    let asked = false;
    function redraw() {
      if (asked) return;
      asked = true;
      requestAnimationFrame(() => { asked = false; update(); draw(); });
    }
    slider.addEventListener('input', redraw);
    view.onChange(redraw);
    new ResizeObserver(redraw).observe(canvas);
    mrc.onDark(redraw);
    update();
    draw();
  };
}(window.mrc));
