// @ts-check
// Robots on the plane, drawn on a canvas: the one drawing of them that pages have.
//
//   const scene = mrc.makeScene(canvas, {
//     robots: [{name, colour, shape, wheelSeparation, wheelRadius}],  // [m]; also the order of `draw`
//     path: {x, y, closed},    // arrays [m] of what the cart drives, nan for a break; may be null
//     plain: true,             // without a grid, and smaller, for a few pixels
//     errorScale: 0.05,        // [m] at the strong end of the trail's colours; without it trails have one colour
//   });
//   scene.draw({
//     robots: [{pose: [x, y, heading], wheels: [right, left], torque: [right, left], limit,
//               trail: {x, y, error, from, to}}],
//     cart: [x, y, heading],   // or carts, a list of such poses
//     drawing: {x, y, speed, most, turns, points, cursor},  // a path that is drawn by hand: speeds up to `most` [m/s]
//                                                    // as colours, negative ones dashed, places of turns on the spot,
//                                                    // and its points [[x, y], ...] [m]
//   });
//
// colour: a CSS colour, or the name of a custom property such as '--robot-1'. shape: a key of mrc.SHAPES.
// wheels: angles [rad]. torque [N m] is drawn as bars up to limit [N m]. trail: arrays [m] from index `from` to `to`,
// both included. Every part of a state but `pose` may be null or absent, and a robot whose pose is null is not drawn.
//
//   scene.fit(x, y, far)     make the view hold points [m], too: with `far` wherever they are, else near the path
//   scene.setPath(path)      replace path and view
//   scene.zoom(factor, pose) zoom, at first about a pose, where it is not null; 0 shows all
//   scene.zoomed()           whether a part is shown only
//   scene.pan(dx, dy)        move what is shown by some CSS pixels
//   scene.toWorld(px, py)    [x, y] [m] of a point of the canvas, in CSS pixels from its upper left corner
//   scene.toScreen(x, y)     the inverse
//
// The canvas has the size that CSS gives it; a change of size, of light and dark, draws the last state again. A robot
// is drawn to scale, but never too small to see which way it points; one far from the path is an arrow at the edge.
// Colours are the custom properties of colours.css. Text has 12 CSS pixels.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const corners = (count, first) => Array.from({length: count}, (_, n) => {
    const angle = first + 2 * Math.PI * n / count;
    return [Math.cos(angle), Math.sin(angle)];
  });
  // Corners of the bodies in a circle of radius 1, x ahead; they tell robots apart without colour.
  mrc.SHAPES = {
    circle: corners(40, 0), square: corners(4, Math.PI / 4), triangle: corners(3, 0), diamond: corners(4, 0),
    hexagon: corners(6, 0), pentagon: corners(5, Math.PI),
  };
  const FAR = 1, LEAST = 16, STEPS = 16, FONT = 12;  // path sizes, half a robot [px], colours of a trail, [px]
  const ERRORS = ['--error-low', '--error-middle', '--error-high'], SPEEDS = ['--speed-slow', '--speed-fast'];
  const LEFT = 48, BELOW = 24, ABOVE = 26, COLUMN = 190;  // [px] round the plane, and of the column at its right

  // Return a number with so many decimals, and a minus as wide as a digit.
  function signed(value, digits) { return value.toFixed(digits).replace(/^-(?=.*[1-9])/, '−').replace(/^-/, ''); }

  // Return the bounds [x low, x high, y low, y high] of points and of earlier bounds.
  function bounded(x, y, before) {
    const box = before ? before.slice() : [Infinity, -Infinity, Infinity, -Infinity];
    for (let n = 0; n < x.length; n++) {
      if (!Number.isFinite(x[n] + y[n])) continue;
      box[0] = Math.min(box[0], x[n]); box[1] = Math.max(box[1], x[n]);
      box[2] = Math.min(box[2], y[n]); box[3] = Math.max(box[3], y[n]);
    }
    return box[0] <= box[1] ? box : null;
  }

  mrc.makeScene = function (canvas, options) {
    const shown = canvas.getContext('2d'), backdrop = document.createElement('canvas'), robots = options.robots;
    let pen = shown, path = null, box = null, limits = null, last = null, style = null, area = null, view = null;
    let drawn = '', lens = {zoom: 1, x: 0, y: 0};
    const least = options.plain ? 5 : LEAST, edge = options.plain ? 2 : 0;

    const planned = ({drawing}) => drawing && drawing.speed;

    function colour(name) { return name.startsWith('--') ? style.getPropertyValue(name).trim() || '#888888' : name; }

    function setPath(given) {
      path = given;
      box = path ? bounded(path.x, path.y) : null;
      const size = box && Math.max(box[1] - box[0], box[3] - box[2], 0.5);
      drawn = '';
      limits = box && box.map((value, n) => value + (n % 2 ? 1 : -1) * FAR * size);
      if (last) draw(last);
    }

    function fit(x, y, far) {
      const clip = (values, low) => limits && !far ? Float64Array.from(values, (value) => Number.isFinite(value)
        ? Math.min(limits[low + 1], Math.max(limits[low], value)) : value) : values;
      box = bounded(clip(x, 0), clip(y, 2), box);
    }

    // Lay out plane and legend, and fit the view into the plane.
    function arrange(state) {
      const width = canvas.clientWidth, height = canvas.clientHeight, density = window.devicePixelRatio || 1;
      const [wide, high] = [Math.round(width * density), Math.round(height * density)];
      if (canvas.width !== wide || canvas.height !== high) { canvas.width = wide; canvas.height = high; }
      pen = shown;
      pen.setTransform(density, 0, 0, density, 0, 0);
      pen.clearRect(0, 0, width, height);
      style = getComputedStyle(canvas);
      pen.font = `${FONT}px ${style.fontFamily}`;
      const torques = state.robots.some((robot) => robot.torque), block = torques ? 60 : 22;
      const listed = (robots.length > 1 || torques) && height >= 240, beside = width >= 560;
      const columns = beside ? 1 : 2, rows = Math.ceil(robots.length / columns);
      area = {left: edge || LEFT, top: edge || ABOVE + (planned(state) && !beside ? 16 : 0), right: width - (edge || (listed && beside ? COLUMN : 10)),
              bottom: height - (edge || BELOW) - (listed && !beside ? rows * block + 8 : 0), listed, torques, block, columns,
              beside};
      const [left, right, low, top] = box || [-1, 1, -1, 1], margin = 1.6 * least;
      // room for a whole robot at the edge: of its true size, and at least of that to which it is drawn
      const robot = Math.max(0.2, ...robots.map(({wheelSeparation}) => 1.6 * (wheelSeparation || 0)));
      const fitted = (extra, around) => Math.min((area.right - area.left - around) / (right - left + extra),
                                                 (area.bottom - area.top - around) / (top - low + extra));
      const scale = Math.min(fitted(robot, 0), fitted(0.01, 2 * margin));
      view = {scale: lens.zoom * Math.max(scale, 1e-6), x: lens.x + (left + right) / 2, y: lens.y + (low + top) / 2,
              px: (area.left + area.right) / 2, py: (area.top + area.bottom) / 2};
    }

    const toScreen = (x, y) => [view.px + (x - view.x) * view.scale, view.py - (y - view.y) * view.scale];
    const toWorld = (px, py) => [view.x + (px - view.px) / view.scale, view.y - (py - view.py) / view.scale];

    function text(words, x, y, align, ink) {
      pen.fillStyle = colour(ink || '--soft');
      pen.textAlign = align;
      pen.fillText(words, x, y);
    }

    // Draw a line through points; nan is a break in it.
    function line(x, y, from, to, closed) {
      let begins = true;
      pen.beginPath();
      for (let n = from; n <= to; n++) {
        const [px, py] = toScreen(x[n], y[n]);
        if (px + py !== px + py) begins = true;
        else if (begins) { pen.moveTo(px, py); begins = false; } else pen.lineTo(px, py);
      }
      if (closed) pen.closePath();
      pen.stroke();
    }

    // Draw grid lines with labels along the left and lower edge.
    function grid() {
      const step = mrc.roundStep(70 / view.scale), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
      const [left, top] = toWorld(area.left, area.top), [right, low] = toWorld(area.right, area.bottom);
      pen.lineWidth = 1;
      pen.strokeStyle = colour('--faint');
      for (let n = Math.ceil(left / step); n * step <= right; n++) {
        const px = Math.round(toScreen(n * step, 0)[0]) + 0.5;
        pen.strokeRect(px, area.top, 0, area.bottom - area.top);
        if (px < area.right - 56) text(signed(n * step, digits), px, area.bottom + 16, 'center');
      }
      for (let n = Math.ceil(low / step); n * step <= top; n++) {
        const py = Math.round(toScreen(0, n * step)[1]) + 0.5;
        pen.strokeRect(area.left, py, area.right - area.left, 0);
        if (py > area.top + 20) text(signed(n * step, digits), area.left - 6, py + 4, 'right');
      }
      text('x [m]', area.right, area.bottom + 16, 'right');
      text('y [m]', area.left - 6, area.top + 10, 'right');
    }

    // Return so many colours, mixed of some: of a trail from no error to the largest, of a path from slow to fast.
    function shades(names = ERRORS) {
      const stops = names.map((name) => {
        pen.fillStyle = colour(name);
        const hex = String(pen.fillStyle);
        return [1, 3, 5].map((n) => parseInt(hex.slice(n, n + 2), 16));
      });
      return Array.from({length: STEPS}, (_, n) => {
        const place = (stops.length - 1) * n / (STEPS - 1), first = Math.min(stops.length - 2, Math.floor(place)), part = place - first;
        return `rgb(${stops[first].map((value, k) => Math.round(value + part * (stops[first + 1][k] - value)))})`;
      });
    }

    // Draw a trail in pieces of one colour; points less than a pixel apart are one, with the largest of their errors.
    function drawTrail(trail, robot, scale) {
      const from = Math.max(0, trail.from || 0), to = Math.min(trail.x.length - 1, trail.to);
      pen.lineJoin = 'round';
      if (!trail.error || !scale || robots.length > 1) {
        pen.strokeStyle = colour(robot.colour);
        pen.lineWidth = scale ? 5 : 2;
        line(trail.x, trail.y, from, to);
      }
      if (!trail.error || !scale) return;
      const mixed = shades();
      let [px, py] = toScreen(trail.x[from], trail.y[from]), worst = 0, shade = -1;
      pen.lineWidth = 2.5;
      for (let n = from + 1; n <= to; n++) {
        const [x, y] = toScreen(trail.x[n], trail.y[n]);
        if (trail.error[n] > worst) worst = trail.error[n];
        if (Math.abs(x - px) + Math.abs(y - py) < 1 && n < to) continue;
        const next = Math.min(STEPS - 1, Math.floor(STEPS * worst / scale));
        if (next !== shade) {
          if (shade >= 0) pen.stroke();
          shade = next;
          pen.strokeStyle = mixed[shade];
          pen.beginPath();
          pen.moveTo(px, py);
        }
        pen.lineTo(x, y);
        [px, py, worst] = [x, y, 0];
      }
      if (shade >= 0) pen.stroke();
    }

    // Draw a path that is drawn by hand: dark where it is slow, with points with their numbers, and the cursor.
    function drawDrawing({x, y, speed, most, turns, points, cursor}) {
      const mixed = shades(SPEEDS);
      pen.lineWidth = 4;
      for (let n = 1; n < (x || []).length; n++) {
        if (speed[n] < 0 && n % 4 < 2) continue;
        pen.strokeStyle = mixed[Math.min(STEPS - 1, Math.floor(STEPS * Math.abs(speed[n]) / most))];
        pen.beginPath();
        const [from, to] = [toScreen(x[n - 1], y[n - 1]), toScreen(x[n], y[n])];
        pen.moveTo(from[0], from[1]);
        pen.lineTo(to[0], to[1]);
        pen.stroke();
      }
      pen.strokeStyle = colour('--ink');
      pen.lineWidth = 1.5;
      (turns || []).forEach((place) => {
        const [px, py] = toScreen(place[0], place[1]);
        pen.beginPath();
        pen.arc(px, py, 11, -0.5 * Math.PI, Math.PI);
        pen.stroke();
      });
      points.forEach((point, n) => {
        const [px, py] = toScreen(point[0], point[1]);
        pen.fillStyle = colour('--ground');
        pen.fillRect(px - 4, py - 4, 8, 8);
        pen.strokeRect(px - 4, py - 4, 8, 8);
        if (points.length <= 30) text(String(n + 1), px + 8, py - 6, 'left', '--ink');
      });
      if (!cursor) return;
      const [px, py] = toScreen(...cursor);
      pen.strokeRect(px - 10, py, 20, 0);
      pen.strokeRect(px, py - 10, 0, 20);
    }

    function outline(shape, size) {
      pen.beginPath();
      (mrc.SHAPES[shape] || mrc.SHAPES.circle).forEach(([x, y]) => pen.lineTo(size * x, size * y));
      pen.closePath();
    }

    // Call a function that draws about the origin, x ahead and y to the left, at a pose; at the edge where it is far.
    function at([x, y, heading], drawBody) {
      const [px, py] = toScreen(x, y), margin = 8;
      const cx = Math.min(area.right - margin, Math.max(area.left + margin, px));
      const cy = Math.min(area.bottom - margin, Math.max(area.top + margin, py)), outside = cx !== px || cy !== py;
      pen.save();
      pen.translate(cx, cy);
      pen.rotate(outside ? Math.atan2(py - cy, px - cx) : -heading);
      pen.scale(1, -1);
      drawBody(outside);
      pen.restore();
    }

    // Draw a wheel of some pixels, with marks that go ahead on its upper side as it turns.
    function drawWheel(offset, length, width, angle) {
      pen.fillStyle = colour('--ink');
      pen.fillRect(-length / 2, offset - width / 2, length, width);
      pen.fillStyle = colour('--ground');
      for (let n = 0; n < 6 && Number.isFinite(angle); n++) {
        const turned = angle + n * Math.PI / 3;
        if (Math.cos(turned) > 0) pen.fillRect(Math.sin(turned) * length / 2 - 0.75, offset - width / 2, 1.5, width);
      }
    }

    function drawRobot(state, robot) {
      const real = robot.wheelSeparation * view.scale / 2 || least, half = Math.max(real, least);
      const length = Math.max(2 * (robot.wheelRadius || 0) * view.scale * half / real, 0.8 * half);
      at(state.pose, (outside) => {
        if (outside) { outline('triangle', 8); pen.fillStyle = colour(robot.colour); pen.fill(); return; }
        for (const [side, angle] of [[-1, 0], [1, 1]]) {
          drawWheel(side * half, length, Math.max(4, 0.25 * half), state.wheels ? state.wheels[angle] : NaN);
        }
        outline(robot.shape, 0.8 * half);
        pen.fillStyle = colour(robot.colour);
        pen.fill();
        pen.lineWidth = 1.5;
        pen.strokeStyle = colour('--ink');
        pen.stroke();
        pen.beginPath();
        pen.moveTo(0, 0);
        pen.lineTo(1.45 * half, 0);
        pen.lineTo(1.15 * half, 0.2 * half);
        pen.moveTo(1.45 * half, 0);
        pen.lineTo(1.15 * half, -0.2 * half);
        pen.lineWidth = 2;
        pen.stroke();
      });
    }

    function drawCart(pose) {
      at(pose, () => {
        pen.beginPath();
        [[1.5, 0], [-0.8, 0.8], [-0.8, -0.8]].forEach(([x, y]) => pen.lineTo(least * x, least * y));
        pen.closePath();
        pen.setLineDash([4, 2]);
        pen.lineWidth = 2;
        pen.strokeStyle = colour('--ink');
        pen.stroke();
        pen.setLineDash([]);
      });
    }

    // Draw grid and path, from a copy where neither view nor colours have changed: a path may have thousands of points.
    function drawBackdrop() {
      const now = [canvas.width, canvas.height, view.scale, view.x, view.y, area.right, area.bottom,
                   colour('--path'), colour('--faint')].join();
      if (now !== drawn) {
        drawn = now;
        backdrop.width = canvas.width;  // clears it
        backdrop.height = canvas.height;
        pen = backdrop.getContext('2d');
        pen.setTransform(shown.getTransform());
        pen.font = shown.font;
        if (!options.plain) grid();
        if (path) {
          clip();
          pen.strokeStyle = colour('--path');
          pen.lineWidth = options.plain ? 3 : 7;
          line(path.x, path.y, 0, path.x.length - 1, path.closed);
        }
        pen = shown;
      }
      pen.drawImage(backdrop, 0, 0, canvas.clientWidth, canvas.clientHeight);
    }

    function clip() {
      pen.beginPath();
      pen.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
      pen.clip();
    }

    // Draw the scale of some colours above the plane, in the first or the second place.
    function drawScale(names, word, most, second) {
      const [x, y, length] = [area.left + (second && area.beside ? 322 : 44), second && !area.beside ? 22 : 6, 96];
      text(`${word}  0`, x - 4, y + 10, 'right');
      shades(names).forEach((shade, n) => {
        pen.fillStyle = shade;
        pen.fillRect(x + n * length / STEPS, y, length / STEPS + 0.5, 10);
      });
      text(most, x + length + 6, y + 10, 'left');
    }

    // Draw a torque [N m] as a bar from the middle; one beyond its limit has an arrow.
    function drawBar(label, value, limit, x, y, width) {
      const room = width - 96, middle = x + 14 + room / 2, part = limit > 0 ? value / limit : 0;
      const end = middle + Math.max(-1, Math.min(1, part)) * room / 2;
      text(label, x, y + 10, 'left');
      pen.fillStyle = colour('--tint');
      pen.fillRect(x + 14, y, room, 11);
      pen.fillStyle = colour('--ink');
      if (Number.isFinite(part)) pen.fillRect(Math.min(middle, end), y, Math.abs(end - middle), 11);
      pen.fillRect(middle - 0.5, y - 2, 1, 15);
      if (Math.abs(part) > 1.001) text(part > 0 ? '▸' : '◂', end, y + 10, part > 0 ? 'left' : 'right', '--warn');
      const digits = limit > 0 ? Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(limit)))) : 3;
      text(Number.isFinite(value) ? `${signed(value, digits)} N m` : '–', x + width, y + 10, 'right', '--ink');
    }

    // Draw names, shapes and torques of the robots, beside the plane or below it.
    function drawList(state) {
      robots.forEach((robot, n) => {
        const width = area.beside ? COLUMN - 16 : (canvas.clientWidth - 24) / 2;
        const x = area.beside ? area.right + 14 : 8 + (n % area.columns) * (width + 8);
        const y = area.beside ? area.top + n * area.block : area.bottom + BELOW + 8
          + Math.floor(n / area.columns) * area.block;
        pen.save();
        pen.translate(x + 7, y + 7);
        outline(robot.shape, 7);
        pen.fillStyle = colour(robot.colour);
        pen.fill();
        pen.restore();
        let name = robot.name || '';
        while (name.length > 1 && pen.measureText(name).width > width - 20) name = `${name.slice(0, -2)}…`;
        text(name, x + 20, y + 11, 'left', '--ink');
        const {torque, limit} = state.robots[n];
        if (!torque) return;
        drawBar('L', torque[1], limit, x, y + 19, width);
        drawBar('R', torque[0], limit, x, y + 37, width);
      });
    }

    function draw(state) {
      last = state;
      if (!canvas.clientWidth || !canvas.clientHeight) return;
      arrange(state);
      drawBackdrop();
      pen.save();
      clip();
      const scale = options.errorScale;
      state.robots.forEach(({trail}, n) => { if (trail && trail.to > 0) drawTrail(trail, robots[n], scale); });
      const known = (pose) => pose && pose.every(Number.isFinite);
      // the first robot on top
      for (let n = robots.length - 1; n >= 0; n--) if (known(state.robots[n].pose)) drawRobot(state.robots[n], robots[n]);
      (state.carts || [state.cart]).filter(known).forEach(drawCart);
      if (state.drawing) drawDrawing(state.drawing);
      pen.restore();
      if (scale && state.robots.some(({trail}) => trail && trail.error)) drawScale(ERRORS, 'error', `${mrc.withUnit(scale, 'm')} and more`, false);
      if (planned(state)) drawScale(SPEEDS, 'speed', mrc.withUnit(state.drawing.most, 'm/s'), true);
      if (area.listed) drawList(state);
    }

    function zoom(factor, pose) {
      if (lens.zoom === 1 && factor > 1 && pose) {
        const [x, y] = [view.x, view.y];
        lens = {zoom: 1, x: pose[0] - x, y: pose[1] - y};
      }
      lens.zoom = Math.min(200, lens.zoom * factor);
      if (lens.zoom < 1.01) lens = {zoom: 1, x: 0, y: 0};
      again();
    }

    function pan(dx, dy) {
      lens.x -= dx / view.scale;
      lens.y += dy / view.scale;
      again();
    }

    const again = () => { if (last) draw(last); };
    new ResizeObserver(again).observe(canvas);
    mrc.onDark(again);
    setPath(options.path);
    arrange({robots: []});
    return {draw, fit, setPath, toWorld, toScreen, zoom, pan, zoomed: () => lens.zoom > 1};
  };
}(window.mrc));
