// @ts-check
// Lesson mode: robot, one chart, numbers, controls and a question in one view. The lessons are files; the server sets
// what their controls set, and takes it back. Answers are checked here, by measuring the rows that come.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const MOST = 2400;  // rows kept

  // Return the number that an answer stands for in a unit: with a comma or a dot, in the unit, with a prefix, or in per
  // cent; NaN for what is none.
  mrc.readAnswer = function (text, unit) {
    const found = text.trim().replace('−', '-').match(/^([-+]?\d*[.,]?\d+(?:e[-+]?\d+)?)\s*(.*)$/i);
    if (!found) return NaN;
    const value = Number(found[1].replace(',', '.')), bare = (words) => words.replace(/[\s·*]/g, '');
    const written = bare(found[2]).replace(/percent|procent|pct/i, '%'), wanted = bare(unit || '');
    if (written === '' || written === wanted) return value;
    if (written === '%' && wanted === '') return value / 100;
    const factor = {m: 1e-3, c: 1e-2, k: 1e3}[written[0]];
    return written.length > 1 && written.slice(1) === wanted && factor ? value * factor : NaN;
  };

  mrc.makeLessons = function (live, panel, button, charts) {
    let lessons = [], running = null, rows = [], read = null, nodes = {}, plan = null, unplanned = '', surface = null;
    let refused = NaN, accepted = NaN, state = '', choices = [], asked = Promise.resolve();
    // whether the lesson has begun, the number of its newest run, how many controls are on their way, and what the choices of a comparison have given
    let begun = false, first = 0, moving = 0, compared = {};
    /** @type {RunValues} */
    let ran = {number: NaN, since: 0, pose: null, values: {}, motion: {}};

    const now = (name) => rows.length ? read(name)(rows[rows.length - 1]) : NaN;
    const value = (target) => {
      const at = target.indexOf('.');
      return (nodes[target.slice(0, at)] || {})[target.slice(at + 1)];
    };
    // Whether the parameters of the newest row's run are known, which come a moment after it.
    const isKnown = () => now('run') >= first && now('run') === ran.number;
    const shown = (number, unit) => mrc.number(number, unit, 3);

    // Return the rows that a measure looks at: of the newest run, in a span of its time; null where it is too short, or
    // the run has not had its parameters for so long.
    function within(over) {
      const time = read('time'), newest = now('time');
      const span = over === 'lap' ? value('reference_cart.period') : over;
      const [from, to] = Array.isArray(span) ? span : [newest - span, newest];
      if (!rows.length || newest < to || time(rows[0]) > from + 0.5 || (!Array.isArray(span) && newest < span)
          || ran.since > Math.max(0, from)) return null;
      return rows.filter((row) => time(row) >= from && time(row) <= to);
    }

    // Return what an answer measures now, or NaN.
    function measured(answer) {
      if (answer.measure === 'accepted') return refused - accepted <= answer.tolerance + 1e-9 ? accepted : NaN;
      const columns = answer.of.map((name) => read(name));
      const among = answer.measure === 'now' ? rows.slice(-1) : within(answer.over);
      if (!among || !among.length) return NaN;
      if (answer.measure === 'now') return columns[0](among[0]);
      const far = among.map((row) => Math.hypot(...columns.map((column) => column(row)))).filter(Number.isFinite);
      if (answer.measure === 'mean') return far.reduce((sum, one) => sum + one, 0) / far.length;
      if (answer.measure === 'farthest') return Math.max(...far);
      return Math.max(...among.flatMap((row) => columns.map((column) => Math.abs(column(row)))).filter(Number.isFinite));
    }

    // Return why nothing can be measured yet, in words; '' where it can.
    function lacking(answer) {
      for (const [target, wanted] of Object.entries(answer.with || {})) {
        if (ran.values[target] !== wanted) return `First set ${target} to ${wanted}.`;
      }
      if (Number.isFinite(measured(answer))) return '';
      if (answer.measure === 'accepted') {
        const more = Number.isFinite(refused) ? ` and refused ${shown(refused, answer.unit)}` : '';
        return `The node has taken ${shown(accepted, answer.unit)}${more}. ${answer.hint || 'Look for the last one that it takes.'}`;
      }
      const span = answer.over === 'lap' ? 'a lap' : Array.isArray(answer.over) ? `to t = ${answer.over[1]} s` : `for ${answer.over} s`;
      if (ran.since > 0 && Array.isArray(answer.over)) {
        return `Reset: this run has its parameters only since t = ${shown(ran.since, 's')}.`;
      }
      return `Let it drive ${span}${ran.since > 0 ? ` after the change at t = ${shown(ran.since, 's')}` : ''}; it is at t = ${shown(now('time'), 's')}.`;
    }

    const KINDS = {
      place({reach, tolerance}) {
        const found = Object.keys(reach).map((name) => `${name} = ${shown(now(name), 'm')}`).join(', ');
        return [Object.entries(reach).every(([name, wanted]) => Math.abs(now(name) - wanted) <= tolerance), `It is ${found}.`];
      },
      number(answer, given) {
        const missing = lacking(answer);
        if (missing) return [null, missing];
        const found = measured(answer);
        // what the node refuses is wrong, however near it is
        if (answer.measure === 'accepted' && given > found + 1e-9) return [false, `The node refuses it: it takes ${shown(found, answer.unit)} at most.`];
        const off = Math.max(answer.tolerance || 0, (answer.share || 0) * Math.abs(found));
        return [Math.abs(given - found) <= off, `Measured: ${shown(found, answer.unit)}.`];
      },
      larger(answer, given) {
        const kept = answer.choices.map((name) => compared[name] || {}), [one, other] = kept.map(({found}) => found);
        if (one >= 0 && other >= 0 && kept[0].conditions !== kept[1].conditions) return [null, 'Start both from the same place.'];
        if (!(one >= 0 && other >= 0)) return [null, `Try both, each ${lacking(answer).replace(/;.*/, '').toLowerCase() || 'from the same place'}.`];
        return [(one > other) === (given === answer.choices[0]),
          `Measured: ${answer.choices[0]} ${shown(one, answer.unit)}, ${answer.choices[1]} ${shown(other, answer.unit)}.`];
      },
      plan({limit, choices: texts}, given) {
        if (!plan) return [null, unplanned || 'The plan has not come yet.'];
        const part = (bends) => {
          const there = plan.limit.filter((_, n) => plan.bends[n] === bends);
          return 100 * there.filter((name) => name === limit).length / there.length;
        };
        const [bent, straight] = [part(true), part(false)];
        return [given === texts[straight < 5 ? 0 : bent < 5 ? 1 : 2],
          `It limits ${Math.round(bent)} % of the bends and ${Math.round(straight)} % of the straights.`];
      },
    };

    // Keep what each choice of the first control has given, and in which conditions: the choice that the run has had.
    function compare() {
      if (!running || running.answer.kind !== 'larger' || moving || !isKnown()) return;
      const {answer, controls} = running, {over} = answer, {[controls[0].sets[0]]: choice = choices[0](), ...others} = ran.motion;
      // changed after the span: what was measured before holds
      if (Array.isArray(over) && ran.since > over[1]) return;
      for (const [name, {run}] of Object.entries(compared)) if (Array.isArray(over) && run === ran.number) delete compared[name];
      const found = measured(answer);
      if (Number.isFinite(found)) {
        compared[String(choice)] = {found, run: ran.number, conditions: JSON.stringify([ran.pose, others])};
      }
    }

    async function showPlan() {
      const lesson = running;
      if (!lesson) return {good: true, text: ''};
      const limits = Object.fromEntries(lesson.controls.map((control, n) => [control.sets[0].replace('plan.', ''), choices[n]()]));
      const found = await mrc.planPath(lesson.plan, limits);
      // the lesson was closed meanwhile
      if (running !== lesson) return {good: true, text: ''};
      plan = found.plan;
      unplanned = found.text;
      if (plan) mrc.stage.draw({...plan, most: Math.max(...plan.speed), points: lesson.plan, cursor: null});
      return {good: Boolean(plan), text: found.text};
    }

    async function showSurface() {
      const {good, text} = await live.ask({do: 'surface'});
      if (good && surface) surface.surface(JSON.parse(text));
    }

    function makeControl(control, n, verdict) {
      const made = mrc.element('label', '', control.label + (control.unit ? ` [${control.unit}]` : ''));
      const written = mrc.element('output', 'soft');
      /** @type {any} */
      const field = mrc.element(control.range ? 'input' : 'select');
      if (control.range) {
        const [min, max, step] = control.range;
        Object.assign(field, {type: 'range', min, max, step});
        field.value = control.value;
      } else control.choices.forEach((choice) => field.append(new Option(String(choice), String(choice), false, choice === control.value)));
      choices[n] = () => control.range ? Number(field.value) : control.choices[field.selectedIndex];
      const show = () => { written.textContent = control.range ? ` ${field.value}` : ''; };
      show();
      const lesson = running;
      const act = async () => {
        if (running !== lesson) return;
        const given = choices[n]();
        if (control.sets[0] === 'picture') { surface.choose(given); return; }
        if (control.sets[0].startsWith('plan.')) {
          const {good, text} = await showPlan();
          if (!good || running !== lesson) { verdict(null, text); return; }
        }
        const {good, text} = await live.ask({do: 'move', control: n, value: given});
        if (good) {
          first = Math.max(first, Number(text));
          if (!(accepted > given)) accepted = Number(given);
          // it was no refusal: the node did not answer in time
          if (refused <= accepted) refused = NaN;
        } else if (!(refused < given)) refused = Number(given);
        verdict(null, good ? '' : text);
      };
      let queued = false, chosen = choices[n]();
      // one after the other, and of those that wait the newest
      mrc.onChoice(field, () => {
        show();
        if (queued || choices[n]() === chosen) return;
        queued = true;
        moving += 1;
        asked = asked.then(() => { queued = false; chosen = choices[n](); return act(); }).finally(() => { moving -= 1; });
      });
      made.append(written, field);
      return made;
    }

    // Fill the panel with a lesson.
    function show(lesson) {
      panel.textContent = '';
      const number = lessons.indexOf(lesson), head = mrc.element('div', 'bar head');
      const choice = mrc.element('select'), close = mrc.element('button', '', 'Close', {type: 'button'});
      choice.setAttribute('aria-label', 'lesson');
      lessons.forEach((one, n) => choice.append(new Option(`${n + 1} ${one.title}${one.fits ? '' : ' (another robot)'}`, one.name)));
      choice.value = lesson.name;
      mrc.onChoice(choice, () => begin(choice.value));
      close.addEventListener('click', () => end(true));
      head.append(choice, close);
      const about = mrc.element('details', 'about', '', {open: window.innerWidth >= 600});
      about.append(mrc.element('summary', '', 'What this is about'), mrc.element('p', '', lesson.text));
      const words = mrc.element('p', 'verdict'), controls = mrc.element('div', 'controls');
      words.setAttribute('role', 'status');
      const verdict = (right, text) => {
        words.textContent = (right === null ? '' : right ? 'Right. ' : 'Not yet. ') + text;
        words.className = `verdict ${right ? 'right' : 'wrong'}`;
      };
      choices = [];
      lesson.controls.forEach((control, n) => controls.append(makeControl(control, n, verdict)));
      panel.append(head, mrc.element('h2', 'unseen', lesson.title), about, controls);
      surface = null;
      if (lesson.picture) {
        const picture = mrc.element('canvas', '', '', {tabIndex: -1});
        picture.setAttribute('role', 'img');
        picture.setAttribute('aria-label', 'the control surface of the fuzzy law, with a dot where the robot is on it');
        panel.append(picture);
        surface = mrc.makeSurface(picture);
        showSurface();
      }
      const form = mrc.element('form', 'bar'), check = mrc.element('button', '', 'Check');
      const next = mrc.element('button', '', 'Next lesson', {type: 'button'});
      /** @type {any} */
      let field = null;
      const {answer} = lesson;
      if (answer.kind === 'number') field = mrc.element('input', '', '', {inputMode: 'decimal', size: 8});
      else if (answer.choices) {
        field = mrc.element('select');
        // no answer is chosen beforehand
        field.append(Object.assign(new Option('choose', '', true, true), {disabled: true}));
        answer.choices.forEach((one) => field.append(new Option(one, one)));
      }
      if (field) {
        field.setAttribute('aria-label', `your answer${answer.unit && answer.kind === 'number' ? ` in ${answer.unit}` : ''}`);
        form.append(field);
        if (answer.unit && answer.kind === 'number') form.append(mrc.element('span', 'soft', answer.unit));
      }
      form.append(check, next);
      next.hidden = !lessons.slice(number + 1).some(({fits}) => fits);
      next.addEventListener('click', () => begin(lessons.slice(number + 1).find(({fits}) => fits).name));
      form.addEventListener('submit', async (event) => {
        event.preventDefault();
        await asked;
        for (let looks = 0; !isKnown() && looks < 30; looks += 1) await new Promise((resolve) => setTimeout(resolve, 100));
        if (running !== lesson) return;
        if (!isKnown()) { verdict(null, 'The new run has not come yet: check again.'); return; }
        const given = answer.kind === 'number' ? mrc.readAnswer(field.value, answer.unit) : field ? field.value : '';
        if (answer.kind === 'number' && Number.isNaN(given)) {
          verdict(false, `Write a number${answer.unit ? `, such as 0.5 ${answer.unit}` : ''}.`);
          return;
        }
        if (answer.choices && !field.value) { verdict(null, 'Choose an answer.'); return; }
        const [right, found] = KINDS[answer.kind](answer, given);
        verdict(right, [found, right ? answer.right : right === false ? answer.wrong : ''].filter(Boolean).join(' '));
      });
      panel.append(mrc.element('p', 'question', lesson.question), form, words);
      return verdict;
    }

    // Enable what moves the robot or checks an answer, or disable it.
    function enable(on) {
      panel.querySelectorAll('.controls :is(input, select), form :is(input, select), form button:not([type])').forEach(
        (/** @type {any} */ one) => { one.disabled = !on; });
    }

    // Begin a lesson by its name; the server takes back what the one before has changed.
    async function begin(name) {
      const lesson = lessons.find((one) => one.name === name);
      if (!lesson) return;
      leave();
      mrc.path.clear();
      running = lesson;
      if (lesson.answer.measure === 'accepted') accepted = lesson.controls[0].value;
      mrc.fold(true);
      panel.hidden = false;
      const verdict = show(lesson);
      enable(false);
      verdict(null, 'The lesson begins …');
      charts.only(lesson.chart || 'none', lesson.show);
      panel.querySelector('select').focus();
      const {good, text} = await live.ask({do: 'lesson', name});
      // it was closed meanwhile, or another one was begun
      if (running !== lesson) return;
      if (good) {
        [begun, state, first] = [true, '', Number(text)];
        enable(true);
      }
      verdict(null, good ? '' : `${text}. The lesson has not begun: close it and begin it again.`);
      if (good && lesson.plan) {
        const shown = await showPlan();
        if (!shown.good) verdict(null, shown.text);
      }
      history.replaceState(null, '', `#lesson=${name}`);
    }

    // Forget the lesson; what the page draws for it goes.
    function leave() {
      if (running && running.plan) mrc.stage.draw(null);
      running = surface = plan = null;
      refused = accepted = NaN;
      [begun, first, compared] = [false, 0, {}];
    }

    async function end(tell) {
      if (!running) return;
      leave();
      panel.hidden = true;
      mrc.fold(false);
      charts.only('', null);
      button.focus();
      history.replaceState(null, '', location.pathname + location.search);
      if (tell) await live.ask({do: 'end'});
    }

    button.addEventListener('click', () => begin((lessons.find(({fits}) => fits) || lessons[0]).name));
    panel.addEventListener('keydown', (event) => { if (event.key === 'Escape') end(true); });
    live.on('lessons', (given) => {
      const first = !lessons.length, again = running;
      lessons = given;
      button.hidden = !lessons.length;
      const named = location.hash.match(/^#lesson=(.+)/);
      if (first && named) begin(decodeURIComponent(named[1]));
      // the connection was lost, and with it the lesson
      else if (again) begin(again.name);
    });
    live.on('columns', () => { read = live.column; });
    live.on('state', ({lesson, run}) => {
      // another page has begun another one, or has ended this one; while it begins, the one before is ended
      if (begun && state === running.name && lesson !== state) end(false);
      [state, ran] = [lesson, run];
    });
    live.on('parameters', (parameters) => {
      const gains = (all) => JSON.stringify(['a', 'b', 'c', 'd'].map((name) => (all.position_controller || {})[`fuzzy.${name}`]));
      const before = nodes;
      nodes = Object.fromEntries(parameters.nodes.map(({role, values}) => [role, values]));
      if (surface && gains(before) !== gains(nodes)) showSurface();
    });
    live.on('rows', (added) => {
      if (rows.length && read('run')(added[added.length - 1]) !== now('run')) rows = [];
      const run = read('run')(added[added.length - 1]);
      rows.push(...added.filter((row) => read('run')(row) === run));
      if (rows.length > MOST) {
        const {over} = running ? running.answer : {}, late = Array.isArray(over) ? over[1] : -Infinity;
        // those of a span that is asked about stay
        rows = rows.filter((row, n) => n >= rows.length - MOST / 2 || read('time')(row) <= late);
      }
      compare();
      if (surface) surface.dot(Math.hypot(now('e1'), now('e2')), Math.atan2(now('e2'), now('e1')));
    });
  };
}(window.mrc));
