// The live page's link to its server: rows of numbers and states come in, requests go out.
// The server calls mrc.live.rows, state, parameters, topics and answer; the page's parts listen with mrc.live.on.
window.mrc = window.mrc || {};
(function (mrc) {
  'use strict';

  // Wall time for an answer [ms]; the server gives up a node before that.
  const PATIENCE = 20000;
  const listeners = {}, waiting = new Map(), early = [];
  let number = 0, ready = false;

  const live = mrc.live = {
    columns: null,
    // Call `listener(value)` for each 'row', 'rows', 'state', 'parameters' or 'topics'.
    on(kind, listener) { (listeners[kind] = listeners[kind] || []).push(listener); },
    tell(kind, value) { (listeners[kind] || []).forEach((listener) => listener(value)); },
    // Ask the server; the promise has {good, text}.
    ask(request) {
      number += 1;
      const mine = number;
      return new Promise((resolve) => {
        waiting.set(mine, resolve);
        // an answer that was lost with the connection never comes
        setTimeout(() => live.answer([mine, false, 'the server of this page gave no answer; load the page again']),
          PATIENCE);
        emitEvent('mrc', {...request, number: mine});
      });
    },
    // Change parameters of a node.
    set(node, values) { return live.ask({do: 'set', node, values}); },
    answer([mine, good, text]) {
      const resolve = waiting.get(mine);
      waiting.delete(mine);
      if (resolve) resolve({good, text});
    },
    rows(text) {
      emitEvent('mrc', {do: 'received'});
      if (!ready || !live.columns) { early.push(['rows', text]); return; }
      const numbers = mrc.unpack(text), width = live.columns.length, rows = [];
      for (let n = 0; n + width <= numbers.length; n += width) rows.push(numbers.subarray(n, n + width));
      live.tell('rows', rows);
    },
    state(value) { keep('state', value); },
    parameters(value) { keep('parameters', value); },
    topics(value) { keep('topics', value); },
    // Return a function that reads a column of a row.
    column(name) { const place = live.columns.indexOf(name); return (row) => row[place]; },
    // Called once the page has its elements.
    begin() { ready = true; flush(); },
  };

  function keep(kind, value) {
    if (!ready) { early.push([kind, value]); return; }
    if (kind === 'state' && !live.columns) { live.columns = value.columns; live.tell('columns', value.columns); flush(); }
    live.tell(kind, value);
  }

  function flush() {
    // the state first: it names the columns
    const [states, others] = [early.filter(([kind]) => kind === 'state'), early.filter(([kind]) => kind !== 'state')];
    early.length = 0;
    states.forEach(([kind, value]) => keep(kind, value));
    others.forEach(([kind, value]) => live[kind](value));
  }
}(window.mrc));
