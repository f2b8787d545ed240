// @ts-check
// The time that a page shows: one clock, which the replay, the charts and all bars of time follow and set. A page that
// is opened with #t=12.5 begins there. Space plays and pauses wherever no control wants it.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const CONTROLS = 'button, select, textarea, summary, a, input:not([type=range])';
  const asked = () => Number((/^#t=([\d.]+)$/.exec(window.location.hash) || [])[1]);

  // Return a clock from `start` to `end` [s]; it stands at `start`. `speed` is simulated seconds in a second.
  mrc.makeClock = function (start, end) {
    const listeners = [];
    let last = null;
    const clock = {
      start, end, time: start, speed: 1, playing: false,
      // Call `listener(clock)` after each change of time, speed or playing.
      onChange(listener) { listeners.push(listener); },
      set(time) {
        clock.time = Math.min(clock.end, Math.max(clock.start, time));
        listeners.forEach((listener) => listener(clock));
      },
      play() {
        if (clock.playing) return;
        clock.playing = true;
        last = null;
        clock.set(clock.time >= clock.end ? clock.start : clock.time);
        requestAnimationFrame(step);
      },
      pause() { clock.playing = false; clock.set(clock.time); },
      toggle() { if (clock.playing) clock.pause(); else clock.play(); },
    };
    if (asked() >= start) clock.time = Math.min(end, asked());

    function step(now) {
      if (!clock.playing) return;
      const passed = last === null ? 0 : (now - last) / 1000;
      last = now;
      if (clock.time + passed * clock.speed >= clock.end) clock.playing = false;
      clock.set(clock.time + passed * clock.speed);
      if (clock.playing) requestAnimationFrame(step);
    }

    return clock;
  };

  document.addEventListener('keydown', (event) => {
    const busy = event.ctrlKey || event.altKey || event.metaKey || /** @type {Element} */ (event.target).closest(CONTROLS);
    if (event.key !== ' ' || busy || !mrc.clock) return;
    mrc.clock.toggle();
    event.preventDefault();
  });
  window.addEventListener('hashchange', () => {
    if (!mrc.clock || !(asked() >= 0)) return;
    mrc.clock.pause();
    mrc.clock.set(asked());
  });

  // Return a button that plays, and a bar that shows and sets the time.
  mrc.makePlayer = function (clock) {
    const play = mrc.element('button', 'play', '', {type: 'button'}), bar = mrc.element('span', 'time-bar');
    const scrubber = mrc.element('input', '', '', {type: 'range', min: clock.start, max: clock.end, step: 'any'});
    scrubber.setAttribute('aria-label', 'Time');
    bar.append(scrubber);
    play.addEventListener('click', clock.toggle);
    scrubber.addEventListener('input', () => {
      const wanted = Number(scrubber.value);  // pausing shows the present time
      clock.pause();
      clock.set(wanted);
    });
    const show = () => {
      play.textContent = clock.playing ? '❚❚ Pause' : '► Play';
      scrubber.value = String(clock.time);
      scrubber.setAttribute('aria-valuetext', `${clock.time.toFixed(2)} s`);
    };
    clock.onChange(show);
    show();
    return {play, bar};
  };
}(window.mrc));
