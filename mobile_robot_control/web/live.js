// @ts-check
// The live page's link to its server: rows of numbers and states come in, requests go out, over one socket.
// The server sends [kind, value], which calls mrc.live.rows, state, parameters, topics or answer; the page's parts listen
// with mrc.live.on. A connection that is lost is made again, and goes on with the row after the last.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  // Wall time for an answer, and until a lost connection is made again [ms]; the server gives up a node before that. A
  // lesson and a recording start processes.
  const PATIENCE = 20000, OF_A_START = 90000, AGAIN = 1000;
  /** @type {Record<string, ((value: any) => void)[]>} */
  const listeners = {};
  /** @type {Map<number, (answer: Answer) => void>} */
  const waiting = new Map();
  // The last request of each kind: the server takes one at a time.
  /** @type {Record<string, Promise<unknown>>} */
  const last = {};
  let number = 0, next = 0;
  /** @type {WebSocket} */
  let socket;

  const live = mrc.live = {
    columns: null,
    // Call `listener(value)` for each 'columns', 'rows', 'state', 'parameters', 'topics', 'lessons' or 'connection'.
    on(kind, listener) { (listeners[kind] = listeners[kind] || []).push(listener); },
    tell(kind, value) { (listeners[kind] || []).forEach((listener) => listener(value)); },
    // Send what needs no answer.
    send(message) { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); },
    // Ask the server; the promise has {good, text}.
    ask(request) {
      number += 1;
      const mine = number, before = last[request.do] || Promise.resolve();
      /** @type {Promise<Answer>} */
      const answered = new Promise((resolve) => {
        waiting.set(mine, resolve);
        before.then(() => {
          // an answer that was lost with the connection never comes
          setTimeout(() => live.answer([mine, false, 'the server of this page gave no answer; load the page again']),
            ['lesson', 'move', 'record'].includes(request.do) ? OF_A_START : PATIENCE);
          live.send({...request, number: mine});
        });
      });
      last[request.do] = answered;
      return answered;
    },
    // Whether every request is answered.
    idle: () => waiting.size === 0,
    // Change parameters of a node.
    set(node, values) { return live.ask({do: 'set', node, values}); },
    answer([mine, good, text]) {
      const resolve = waiting.get(mine);
      waiting.delete(mine);
      if (resolve) resolve({good, text});
    },
    rows([text, after]) {
      live.send({do: 'received'});
      next = after;
      const numbers = mrc.unpack(text), width = live.columns.length, rows = [];
      for (let n = 0; n + width <= numbers.length; n += width) rows.push(numbers.subarray(n, n + width));
      live.tell('rows', rows);
    },
    state(value) {
      // the first of all messages
      if (!live.columns) { live.columns = value.columns; live.tell('columns', value.columns); }
      live.tell('state', value);
    },
    parameters(value) { live.tell('parameters', value); },
    topics(value) { live.tell('topics', value); },
    lessons(value) { live.tell('lessons', value); },
    // Return a function that reads a column of a row.
    column(name) { const place = live.columns.indexOf(name); return (row) => row[place]; },
    // Open the connection; the page's parts listen.
    begin() {
      socket = new WebSocket(`${location.protocol.replace('http', 'ws')}//${location.host}/live?from=${next}`);
      socket.addEventListener('message', (event) => {
        const [kind, value] = JSON.parse(event.data);
        live[kind](value);
      });
      socket.addEventListener('open', () => live.tell('connection', true));
      socket.addEventListener('close', () => { live.tell('connection', false); setTimeout(live.begin, AGAIN); });
      mrc.socket = socket;
    },
  };
}(window.mrc));
