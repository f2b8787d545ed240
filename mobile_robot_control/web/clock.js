// @ts-check
// The time that a page shows: one clock, which the replay, its scrubber and all charts follow and set.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

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
}(window.mrc));
