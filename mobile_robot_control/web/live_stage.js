// @ts-check
// The robot on the plane, live: the scene of scene.js, fed with rows; a start pose is dragged on it.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const KEPT = 1200;  // rows of the trail: a minute

  const ARROWS = {ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0]};

  // Return the stage on a canvas; `placed(pose)` is called with a pose [x, y, heading] that was dragged or moved by keys,
  // and `moved(pose)` on its way there.
  mrc.makeStage = function (canvas, placed, moved) {
    const trail = {x: [], y: [], error: [], from: 0, to: -1};
    let scene = null, read = null, run = null, newest = null, limit = 0, path = null, start = null, asked = false;
    let geometry = {wheelSeparation: 0.35, wheelRadius: 0.035}, fitted = 0;

    function make() {
      scene = mrc.makeScene(canvas, {
        robots: [{name: 'robot', colour: '--robot-1', shape: 'circle', ...geometry}], path, errorScale: 0.05});
      draw();
    }

    function draw() {
      asked = false;
      if (!scene || !newest) return;
      const value = (name) => read[name](newest);
      const pose = start || [value('x'), value('y'), value('heading')];
      const torque = [value('right_applied'), value('left_applied')];
      scene.draw({
        robots: [{pose, wheels: [value('right_angle'), value('left_angle')],
                  torque: torque.every(Number.isFinite) ? torque : null, limit: limit || largest, trail}],
        cart: [value('ref_x'), value('ref_y'), value('ref_heading')], drawing});
      const now = performance.now();
      if (now - described < 5000) return;
      described = now;
      const [x, y] = pose.map((number) => mrc.number(number, 'm', 3));
      canvas.setAttribute('aria-label', `the robot on the plane, at ${x}, ${y}; the cart at ${
        mrc.number(value('ref_x'), 'm', 3)}, ${mrc.number(value('ref_y'), 'm', 3)}; arrow keys disturb it`);
    }

    let described = -Infinity;
    let drawing = null;  // of live_path.js
    // Return the point of the plane under a pointer [m].
    function pointed(event) {
      const box = canvas.getBoundingClientRect();
      return scene.toWorld(event.clientX - box.left, event.clientY - box.top);
    }

    let largest = 0.1;  // [N m]: of the bars, where there is no limit

    function ask() { if (!asked) { asked = true; requestAnimationFrame(draw); } }

    function add(row) {
      if (row[0] !== run) {
        run = row[0];
        trail.x.length = trail.y.length = trail.error.length = 0;
      }
      newest = row;
      for (const name of ['right_applied', 'left_applied']) {
        if (Number.isFinite(read[name](row))) largest = Math.max(largest, Math.abs(read[name](row)));
      }
      const [x, y] = [read.x(row), read.y(row)];
      if (!Number.isFinite(x + y)) return;
      trail.x.push(x); trail.y.push(y); trail.error.push(Math.hypot(read.e1(row), read.e2(row)));
      if (trail.x.length > KEPT) { trail.x.shift(); trail.y.shift(); trail.error.shift(); }
      trail.to = trail.x.length - 1;
    }

    mrc.live.on('columns', (columns) => {
      read = Object.fromEntries(columns.map((name) => [name, mrc.live.column(name)]));
    });
    mrc.live.on('rows', (rows) => {
      rows.forEach(add);
      if (!scene) make();
      const now = performance.now();
      // the plane stays where it is while a pose is placed on it
      if (!start && (now - fitted > 500 || rows.length > 20)) { fitted = now; scene.fit(trail.x, trail.y); }
      ask();
    });
    mrc.live.on('parameters', (parameters) => {
      const values = Object.assign({}, ...parameters.nodes.map((node) => node.values));
      const found = {wheelSeparation: values['robot.wheel_separation'], wheelRadius: values['robot.wheel_radius']};
      const changed = JSON.stringify([found, parameters.path]) !== JSON.stringify([geometry, path]);
      if (found.wheelSeparation > 0 && changed) { geometry = found; path = parameters.path; if (newest) make(); }
      const limits = parameters.nodes.map((node) => node.values.max_wheel_torque).filter((value) => value > 0);
      limit = limits.length ? Math.min(...limits) : 0;
    });

    // Drag a start pose: press where the robot is to stand, pull where it is to look.
    canvas.addEventListener('pointerdown', (event) => {
      if (!canvas.classList.contains('placing') || !scene) return;
      canvas.setPointerCapture(event.pointerId);
      const [x, y] = pointed(event);
      start = [x, y, start ? start[2] : 0];
      held = true;
      show();
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!held) return;
      const [x, y] = pointed(event);
      if (Math.hypot(x - start[0], y - start[1]) > 0.02) start[2] = Math.atan2(y - start[1], x - start[0]);
      show();
    });
    canvas.addEventListener('pointerup', () => {
      if (!held) return;
      held = false;
      placed(start);
    });
    canvas.addEventListener('pointercancel', () => { held = false; });
    canvas.addEventListener('keydown', (event) => {
      if (!start || event.ctrlKey || event.altKey || event.metaKey) return;
      if (ARROWS[event.key]) {
        const [right, up] = ARROWS[event.key];
        if (event.shiftKey) start[2] = Math.atan2(Math.sin(start[2] + 0.1 * (up - right)), Math.cos(start[2] + 0.1 * (up - right)));
        else { start[0] += 0.05 * right; start[1] += 0.05 * up; }
        show();
      } else if (event.key === 'Enter') placed(start);
      else return;
      event.preventDefault();
    });
    let held = false;
    function show() { if (moved) moved(start); ask(); }
    // Begin to place the robot, at where it stands, or end it.
    function place(on) {
      start = on && newest ? ['x', 'y', 'heading'].map((name) => read[name](newest)) : null;
      held = false;
      if (start) { canvas.focus(); show(); } else ask();
    }
    return {pointed, place, draw: (given) => { drawing = given; ask(); }, redraw: ask, reach: (point) => scene && scene.fit([point[0]], [point[1]], true), newest: () => newest, path: () => path, toScreen: (x, y) => scene.toScreen(x, y)};
  };
}(window.mrc));
