// @ts-check
// The convergence of a search over its generations, in place of the picture of the figure `search`.
(function (mrc) {
  'use strict';

  const data = JSON.parse(document.getElementById('search-data').textContent);
  const host = document.querySelector('.charts[data-figure=search]');
  const box = host.appendChild(mrc.element('div', 'chart')), head = mrc.element('div', 'head');
  const shown = mrc.element('div', 'legend');
  head.append(mrc.element('h4', '', 'objective over generations, logarithmic scale'), shown);
  box.append(head);
  const above = [...data.best, ...data.mean].every((value) => value === null || value > 0);

  function show(n) {
    const mean = data.mean[n] === null ? 'not known' : mrc.number(data.mean[n]);
    shown.textContent = `generation ${data.number[n]}: best ${mrc.number(data.best[n])}, mean ${mean}, `
      + `${data.lost[n]} not scored`;
  }

  const axis = (more) => ({stroke: () => mrc.colour('--soft'), font: '12px system-ui, sans-serif', ticks: {show: false},
                           grid: {stroke: () => mrc.colour('--faint'), width: 1}, ...more});
  const plot = new uPlot({
    width: Math.max(box.clientWidth, 300), height: 260, legend: {show: false},
    cursor: {y: false, drag: {x: true, y: false}},
    scales: {x: {time: false}, y: above ? {distr: 3} : {}},
    axes: [axis({size: 28, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]}), axis({size: 64})],
    series: [{}, {label: 'mean', stroke: () => mrc.colour('--soft'), width: 1.5, dash: [4, 4], points: {show: data.mean.length < 3}},
             {label: 'best', stroke: () => mrc.colour('--robot-1'), width: 2.5, points: {show: data.best.length < 3}}],
    hooks: {setCursor: [(chart) => show(chart.cursor.idx === null || chart.cursor.idx === undefined
      ? data.number.length - 1 : chart.cursor.idx)]},
  }, [data.number, data.mean, data.best], box);
  show(data.number.length - 1);
  host.closest('figure').classList.add('charted');
  new ResizeObserver(() => requestAnimationFrame(() => {
    if (box.clientWidth > 0 && box.clientWidth !== plot.width) plot.setSize({width: box.clientWidth, height: 260});
  })).observe(box);
  mrc.onDark(() => plot.redraw());
  mrc.search = plot;
}(window.mrc));
