// @ts-check
// The start of a report's page: its numbers, its one clock, and the replay; charts take both from here.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const block = document.getElementById('run-data');
  if (!block) return;
  mrc.runData = JSON.parse(block.textContent);
  mrc.clock = mrc.makeClock(mrc.runData.start, mrc.runData.end);
  mrc.replay = mrc.makeReplay(document.getElementById('replay'), mrc.runData, mrc.clock);
}(window.mrc));
