// @ts-check
// Six short lessons: each has two controls, one question, and an answer that is checked, most of them by measuring.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const value = (role, name) => (nodes[role] || {})[name];
  let nodes = {}, rows = [], numbers = null, read = null;

  // Return the newest number of a column.
  const now = (name) => rows.length ? read(name)(rows[rows.length - 1]) : NaN;
  // Return a column over the last seconds of the run.
  const last = (name, seconds) => rows.filter((row) => read('time')(row) > now('time') - seconds).map(read(name));
  const set = (node, values) => mrc.live.set(node, values);
  // Begin a new run beside the cart's start: so far ahead of it and to its left, in its frame [m].
  function startAt(ahead, left) {
    if (!path) return Promise.resolve({good: false, text: 'the curve of this cart is not known here'});
    const heading = Math.atan2(path.y[1] - path.y[0], path.x[1] - path.x[0]);
    return mrc.live.ask({do: 'reset', pose: [
      path.x[0] + ahead * Math.cos(heading) - left * Math.sin(heading),
      path.y[0] + ahead * Math.sin(heading) + left * Math.cos(heading), heading]});
  }
  let path = null;
  const near = (found, wanted, tolerance) => Math.abs(found - wanted) <= tolerance;
  const shown = (number, unit) => mrc.number(number, unit, 3);

  const place = {ahead: 0, left: 0};
  const put = async () => {
    const held = await set('plant', {paused: true});
    return held.good ? startAt(place.ahead, place.left) : held;
  };
  const share = {k1: 0, k2: 0};
  const giveShare = () => set('velocity_controller', {
    'gains.k1': Math.max(0.01, share.k1) * numbers.chapter.gains.k1, 'gains.ti1': numbers.chapter.gains.ti1,
    'gains.k2': Math.max(0.01, share.k2) * numbers.chapter.gains.k2, 'gains.ti2': numbers.chapter.gains.ti2});
  const beside = {distance: 0.5, law: 'backstepping'}, peaks = {};
  let watched = null;
  async function startBeside() {
    const chosen = await set('position_controller', {controller_type: beside.law});
    if (!chosen.good) return chosen;
    await set('plant', {paused: false});
    watched = {law: beside.law, distance: beside.distance, run: now('run')};
    return startAt(0, -beside.distance);
  }

  // Keep the largest torque that was asked for in the first second of a run that was started beside the path.
  function watch(row) {
    const [run, time, right, left] = ['run', 'time', 'right_asked', 'left_asked'].map((name) => read(name)(row));
    if (!watched || run === watched.run || time > 1) return;
    const key = `${watched.law} ${watched.distance}`, asked = Math.max(Math.abs(right), Math.abs(left));
    if (watched.begun !== run) { watched.begun = run; peaks[key] = 0; }
    if (asked > peaks[key]) peaks[key] = asked;
  }

  const BENDS = [[0, 0], [1.5, 0], [1.5, 1], [0, 1]];
  const limits = {speed: 1, torque: 0.3};
  let timed = null;
  // Plan a path with two bends for the limits of the lesson, and draw it on the plane.
  async function time() {
    const {plan, text} = await mrc.planPath(BENDS, {
      'timing.max_linear_velocity': limits.speed, 'timing.max_wheel_torque': limits.torque});
    timed = plan;
    if (plan) mrc.stage.draw({...plan, most: Math.max(...plan.speed), points: BENDS, cursor: null});
    return {good: Boolean(plan), text};
  }
  // Return the share of a plan's points, in bends or on straights, at which the torque limits the motion [%].
  function limited(bends) {
    const there = timed.limit.filter((_, n) => timed.bends[n] === bends);
    return 100 * there.filter((name) => name === 'wheel torque').length / there.length;
  }

  const LESSONS = [
    {title: 'What e1, e2 and e3 are', text: 'The tracking error is seen from the robot: e1 is how far the cart is ahead, '
       + 'e2 how far to the left, e3 how much its heading is turned counter-clockwise. The controls hold the run and '
       + 'place the robot beside the cart: ahead of it, and to its left.',
     controls: [
       {label: 'robot ahead of the cart [m]', range: [-0.5, 0.5, 0.05, 0], act: (given) => { place.ahead = given; return put(); }},
       {label: "robot to the cart's left [m]", range: [-0.5, 0.5, 0.05, 0], act: (given) => { place.left = given; return put(); }}],
     question: 'Place the robot so that e1 = 0.2 m and e2 = -0.1 m, and check.', answer: 'none',
     check: () => near(now('e1'), 0.2, 0.02) && near(now('e2'), -0.1, 0.02)
       ? [true, 'The cart is 0.2 m ahead and 0.1 m to the right of the robot.']
       : [false, `It is e1 = ${shown(now('e1'), 'm')}, e2 = ${shown(now('e2'), 'm')}. A robot ahead of the cart has the `
         + 'cart behind it: e1 is negative then.']},
    {title: "Why the chapter's gains explode below 1577 Hz", text: "The chapter's velocity gains were evolved in "
       + 'continuous time. A sampled loop holds each torque for a period: with so large a gain the next sample finds the '
       + 'velocity beyond its target by more than it was short of it. The node computes this, and refuses. The arrows '
       + 'beside the parameters take the gains back.',
     controls: [
       {label: 'share of K1', range: [0.02, 1, 0.02, 0.02], act: (given) => { share.k1 = given; return giveShare(); }},
       {label: 'share of K2', range: [0.02, 1, 0.02, 0.02], act: (given) => { share.k2 = given; return giveShare(); }}],
     question: 'Which share of both gains, in per cent, is the largest that the velocity loop takes at its rate here?',
     answer: 'number',
     check: (given) => {
       const largest = 100 * value('velocity_controller', 'velocity_rate') / numbers.chapter.rate;
       return near(given, largest, 3)
         ? [true, `${shown(largest, '%')}: the rate divided by ${Math.round(numbers.chapter.rate)} Hz. What a period times `
            + 'the gain may be is fixed, so that half the rate takes half the gain.']
         : [false, 'Move both controls until the node refuses; its words name the slowest stable rate, too.'];
     }},
    {title: 'Backstepping and hybrid backstepping, started beside the path', text: 'Backstepping pulls at once, with a '
       + 'command that grows with the error. The hybrid law turns on the spot until the cart is in sight, and fades '
       + 'backstepping in.',
     controls: [
       {label: 'law', choices: ['backstepping', 'hybrid_backstepping'], act: (given) => { beside.law = given; return startBeside(); }},
       {label: 'start to the right of the path [m]', range: [0.1, 1, 0.1, 0.5], act: (given) => { beside.distance = given; return startBeside(); }}],
     question: 'Which of the two asks for the larger torque in the first second? Start both from the same distance.',
     answer: ['backstepping', 'hybrid_backstepping'],
     check: (given) => {
       const [one, other] = ['backstepping', 'hybrid_backstepping'].map((law) => peaks[`${law} ${beside.distance}`]);
       if (!(one > 0 && other > 0)) return [false, `Start both from ${beside.distance} m, and let each drive for a second.`];
       const measured = `Backstepping asked for ${shown(one, 'N m')}, the hybrid law for ${shown(other, 'N m')}.`;
       return [(one > other) === (given === 'backstepping'), measured];
     }},
    {title: 'The fuzzy surface', text: 'The fuzzy law knows two numbers, distance and bearing of the cart, and its ten '
       + 'rules make a surface over them. The dot is the robot. There is no feed-forward: without an error it does not move.',
     controls: [
       {label: 'surface of', choices: ['linear', 'angular'], act: (given) => { surface.choose(given); return {good: true, text: ''}; }},
       {label: 'law', choices: ['backstepping', 'fuzzy'], act: (given) => set('position_controller', {controller_type: given})}],
     question: 'The law runs, and the robot follows: how far behind the cart does it stay, on average [m]?', answer: 'number',
     extra: (element) => { surface = mrc.makeSurface(element); },
     check: (given) => {
       if (value('position_controller', 'controller_type') !== 'fuzzy') return [false, 'Choose the fuzzy law first.'];
       const [e1, e2] = [last('e1', 5), last('e2', 5)];
       if (!(now('time') - read('time')(rows[0]) > 5)) return [false, 'Let it follow for five seconds.'];
       const mean = e1.reduce((sum, one, n) => sum + Math.hypot(one, e2[n]), 0) / e1.length;
       return [near(given, mean, Math.max(0.3 * mean, 0.01)), `In the last five seconds it was ${shown(mean, 'm')}: as far `
         + 'as the surface needs to ask for the speed of the cart.'];
     }},
    {title: 'Saturation and windup', text: 'A motor has a largest torque. While it is reached, an integrator that goes on '
       + 'integrating winds up, and the robot overshoots afterwards. This velocity controller knows its limit and holds '
       + 'the integrators meanwhile. Lower the limit, and watch the errors.',
     controls: [
       {label: 'limit of the torques, 0 for none [N m]', range: [0, 1, 0.05, 0], act: (given) => set('velocity_controller', {max_wheel_torque: given})},
       {label: 'lap time [s]', range: [8, 32, 1, 16], act: (given) => set('reference_cart', {period: given})}],
     question: 'How large must the limit be, that it is never reached on this curve [N m]? Without one, the chart tells.',
     answer: 'number',
     check: (given) => {
       if (value('velocity_controller', 'max_wheel_torque') > 0) return [false, 'Take the limit away (0) first.'];
       const lap = value('reference_cart', 'period');
       if (!(now('time') - read('time')(rows[0]) > 0.97 * lap)) return [false, 'Let it drive a lap.'];
       const asked = ['right_asked', 'left_asked'].flatMap((name) => last(name, lap));
       const most = Math.max(...asked.filter(Number.isFinite).map(Math.abs));
       return [near(given, most, 0.15 * most), `In the last lap at most ${shown(most, 'N m')} were asked for.`];
     }},
    {title: 'Where a torque limit slows the robot down', text: 'A path with two bends, timed to be as fast as the limits '
       + 'allow: the plane shows where it is slow. Half of the torque is planned with. In a bend one wheel has to turn '
       + 'faster and the other one slower, which takes torque; what else does?',
     controls: [
       {label: 'torque of a motor [N m]', range: [0.1, 1, 0.05, 0.3], act: (given) => { limits.torque = given; return time(); }},
       {label: 'largest speed [m/s]', range: [0.2, 2, 0.1, 1], act: (given) => { limits.speed = given; return time(); }}],
     question: 'At a speed of 1 m/s and 0.3 N m, where does the torque limit the motion?',
     close: () => mrc.stage.draw(null),
     answer: ['in the bends alone', 'on the straights alone', 'in the bends and on the straights'],
     check: async (given) => {
       if (!timed) {
         const {good, text} = await time();
         if (!good) return [false, text];
       }
       const [bent, straight] = [limited(true), limited(false)];
       const found = straight < 5 ? 'in the bends alone' : bent < 5 ? 'on the straights alone' : 'in the bends and on the straights';
       return [given === found, `It limits ${Math.round(bent)} % of the bends and ${Math.round(straight)} % of the straights: `
         + 'the robot speeds up out of one bend and brakes before the next one, and both take torque.'];
     }},
  ];
  let surface = null;

  // Make one control of a lesson.
  function makeControl({label, range, choices, act}, verdict) {
    const made = mrc.element('label', '', label);
    const field = mrc.element(range ? 'input' : 'select'), written = mrc.element('span', 'soft');
    if (range) {
      const [min, max, step, value] = range;
      Object.assign(field, {type: 'range', min, max, step, value});
      field.addEventListener('input', () => { written.textContent = ` ${field.value}`; });
    } else choices.forEach((choice) => field.append(new Option(choice, choice)));
    field.addEventListener('change', async () => {
      if (!numbers) await fetchNumbers();
      const {good, text} = await act(range ? Number(field.value) : field.value);
      verdict(good ? null : false, good ? '' : text);
    });
    made.append(written, field);
    return made;
  }

  async function fetchNumbers() {
    const {good, text} = await mrc.live.ask({do: 'lesson'});
    if (!good) return;
    numbers = JSON.parse(text);
    if (surface) surface.surface(numbers.surface);
  }

  // Fill a container with the lessons.
  mrc.makeLessons = function (container) {
    for (const lesson of LESSONS) {
      const details = mrc.element('details'), controls = mrc.element('div', 'controls'), words = mrc.element('p', 'verdict');
      words.setAttribute('role', 'status');
      const verdict = (right, text) => {
        words.textContent = (right === null ? '' : right ? 'Right. ' : '') + text;
        words.className = `verdict ${right === null ? '' : right ? 'right' : 'wrong'}`;
      };
      lesson.controls.forEach((control) => controls.append(makeControl(control, verdict)));
      details.append(mrc.element('summary', '', lesson.title), mrc.element('p', '', lesson.text), controls);
      if (lesson.extra) {
        const element = mrc.element('canvas');
        details.append(element);
        lesson.extra(element);
      }
      const bar = mrc.element('div', 'bar'), check = mrc.element('button', '', 'Check');
      let field = null;
      if (lesson.answer === 'number') {
        field = mrc.element('input');
        field.inputMode = 'decimal';
        field.size = 8;
      } else if (Array.isArray(lesson.answer)) {
        field = mrc.element('select');
        lesson.answer.forEach((choice) => field.append(new Option(choice, choice)));
      }
      if (field) { field.setAttribute('aria-label', 'your answer'); bar.append(field); }
      bar.append(check);
      check.addEventListener('click', async () => {
        check.disabled = true;
        if (!numbers) await fetchNumbers();
        check.disabled = false;
        const given = field ? field.value.trim().replace(',', '.') : '';
        if (lesson.answer === 'number' && (given === '' || Number.isNaN(Number(given)))) {
          verdict(false, 'Write a number.');
        } else {
          check.disabled = true;
          verdict(...await lesson.check(lesson.answer === 'number' ? Number(given) : given));
          check.disabled = false;
        }
      });
      details.append(mrc.element('p', 'question', lesson.question), bar, words);
      details.addEventListener('toggle', () => {
        if (details.open) fetchNumbers();
        else if (lesson.close) lesson.close();
      });
      container.append(details);
    }

    mrc.live.on('columns', () => { read = mrc.live.column; });
    mrc.live.on('parameters', (parameters) => {
      const before = nodes;
      nodes = Object.fromEntries(parameters.nodes.map(({role, values}) => [role, values]));
      path = parameters.path;
      const gains = (all) => JSON.stringify(['a', 'b', 'c', 'd'].map((name) => (all.position_controller || {})[`fuzzy.${name}`]));
      if (numbers && gains(before) !== gains(nodes)) fetchNumbers();
    });
    mrc.live.on('rows', (added) => {
      if (rows.length && read('run')(added[added.length - 1]) !== now('run')) rows = [];
      rows.push(...added);
      if (rows.length > 1200) rows = rows.slice(-800);
      added.forEach(watch);
      if (surface) surface.dot(Math.hypot(now('e1'), now('e2')), Math.atan2(now('e2'), now('e1')));
    });
  };
}(window.mrc));
