// SPDX-License-Identifier: Apache-2.0
'use strict';

/// What a series is, other than its renderer.
function seriesTitle(series, files) {
  return [series.scene, ...series.held, ...(series.views > 1 ? [`mean over ${series.views} views`] : []),
          ...(series.conventions === 'gsplat' ? [] : [series.conventions]),
          ...(files.length > 1 ? [files[series.file].file] : [])].join(', ');
}

/// The same in a few words.
function dominanceWords(series) {
  const [first, ...rest] = series.dominance;
  return first.stage + rest.map(part => `, ${part.stage} from ${format.count(part.from)}`).join('');
}

/// Says which stage is the longest where, in one sentence.
function dominanceText(series, quantity) {
  const [first, ...rest] = series.dominance;
  if (!rest.length) return `${first.stage} is the longest stage throughout.`;
  return `${first.stage} is the longest stage at first` +
    rest.map(part => `, ${part.stage} from ${format.count(part.from)} ${quantity.unit} on`).join('') + '.';
}

/// The part of the page about one quantity of scaling.js: a chooser of series, both plots, and exponents of all
/// series. Gives {element, draw}, where `draw` wants the element in the page; null without series.
function scalingSection(name, wanted, files, rows, render) {
  const quantity = scaling.quantities[name], all = scaling.series(rows, name);
  if (!all.length) return null;
  const titles = all.map(one => `${one.renderer} — ${seriesTitle(one, files)}`);
  const chosen = Math.max(0, titles.indexOf(wanted.series[name]));
  const series = all[chosen];
  const choose = element('select', {'data-quantity': name, onchange: event => {
    wanted.series[name] = event.target.value;
    render();
    document.querySelector(`select[data-quantity=${name}]`).focus();
  }}, ...titles.map((title, i) => element('option', {value: title, selected: i === chosen}, title)));

  const exponent = curve => ({title: curve, number: true, value: one => one.fits[curve]?.exponent ?? null,
                              text: one => scalingPlots.exponentText(one.fits[curve])});
  const fitted = scaling.curves.filter(curve => all.some(one => one.fits[curve]));
  const table = sortableTable({
    caption: `Exponents of growth with ${quantity.unit}`, rows: all,
    columns: [{title: 'renderer', value: one => one.renderer}, ...fitted.map(exponent),
              {title: 'longest stage', value: dominanceWords},
              {title: 'measured with', value: one => seriesTitle(one, files)}]});
  const times = element('div', {class: 'chart'}), memory = element('div', {class: 'chart'});
  const hasMemory = series.points.some(point => point.memory > 0);
  return {
    element: element('div', {id: `scaling-${name}`}, element('h3', {}, quantity.title),
      element('div', {class: 'choosers'}, element('label', {}, 'Series', choose)),
      element('div', {class: 'side'}, times, ...(hasMemory ? [memory] : [])),
      element('p', {class: 'dominance'}, dominanceText(series, quantity)), table),
    draw() {
      charts.draw(times, look => scalingPlots.times(series, quantity, look));
      if (hasMemory) charts.draw(memory, look => scalingPlots.memory(series, quantity, look));
    },
  };
}
