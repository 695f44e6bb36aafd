// SPDX-License-Identifier: Apache-2.0
'use strict';

/// The plots for pages elsewhere, [name of a file, specification]: for each scene those of its first choices, for
/// each backend where there are several; and growth of the quickest series.
function figuresOf(rows, files) {
  const figures = [];
  for (const scene of stats.distinct(rows, row => row.scene)) {
    const {rows: chosen} = choices.narrow(rows.filter(row => row.scene === scene), files, {});
    const list = choices.recordsOf(chosen, files), panels = choices.panels(list, files);
    const baseline = choices.baselines(list)[0];
    panels.forEach((panel, i) => {
      const {records} = panel, file = panels.length > 1 ? `${scene}-${panel.title.replaceAll(/[^a-z0-9]+/gi, '-')}` : scene;
      const known = records.filter(record => record.psnr !== null), front = stats.pareto(known);
      const exact = records.filter(record => record.bounds === style.inOrder(records.map(one => one.bounds)).pop() &&
                                   stats.speedup(record, list, baseline) !== null);
      if (known.length)
        figures.push([`pareto-${file}`, look => plots.pareto(known, front, {clock: 'total', shape: 'bounds'}, look)]);
      figures.push([`stages-${file}`, look => plots.stagesStacked(
        choices.quickest(records, 12).map(record => ({...record, label: record.short})), look)]);
      if (exact.length > 1) figures.push([`speedup-${file}`, look => plots.speedups(exact, baseline, 'total', look)]);
    });
  }
  for (const [name, quantity] of Object.entries(scaling.quantities)) {
    const [series] = sortedSeries(rows, name);
    if (!series) continue;
    figures.push([`scaling-${name}`, look => scalingPlots.times(series, quantity, look)]);
    if (series.points.some(point => point.memory > 0))
      figures.push([`scaling-${name}-memory`, look => scalingPlots.memory(series, quantity, look)]);
  }
  return figures;
}

/// Leaves the figures in the page as base64 of SVG files, for benchmarks/figures.sh to fetch.
async function writeFigures(rows, files) {
  const stand = element('div', {id: 'figures', hidden: true});
  for (const [name, specify] of figuresOf(rows, files)) {
    const bytes = new TextEncoder().encode(await charts.svgOf(specify));
    const text = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
    stand.append(element('p', {'data-figure': name}, text), '\n');
  }
  document.body.append(stand);
}
