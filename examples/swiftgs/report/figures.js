// SPDX-License-Identifier: Apache-2.0
'use strict';

/// What the times of a record or series were measured on.
function machineOf(one, files) {
  const {machine} = files[one.file];
  return one.backend === 'cuda' ? machine.gpu : machine.cpu;
}

/// The plots of one scene for pages elsewhere, as its first choices are: those of each backend where there are several.
function figuresOfScene(scene, rows, files) {
  const figures = [];
  const {rows: chosen} = choices.narrow(rows.filter(row => row.scene === scene), files, {});
  const list = choices.recordsOf(chosen, files), panels = choices.panels(list, files);
  const baseline = choices.baselines(list)[0];
  for (const {title, records} of panels) {
    const where = `${choices.sceneTitle(chosen[0])}, ${machineOf(records[0], files)}`;
    const name = scene + (panels.length > 1 ? '-' + title : '');
    const add = (kind, what, specify) =>
      figures.push({name: `${kind}-${name}`, title: `${what}: ${where}`, specify, from: files[records[0].file]});
    const known = stats.withError(records), front = stats.pareto(known);
    if (known.length) add('pareto', 'Run time against error', look => plots.pareto(known, front, look));
    const few = choices.quickest(records, 12);
    add('stages', 'Stages', look => bars.stagesStacked(few, look));
    const bounds = style.inOrder(records.map(one => one.bounds)).pop();
    const compared = records.filter(one => one.bounds === bounds && stats.speedup(one, list, baseline) !== null);
    if (compared.length > 1)
      add('speedup', `Speed-up over ${baseline} with ${bounds}`,
          look => bars.speedups(compared, baseline, look));
  }
  return figures;
}

/// What a series is, other than its renderer.
const seriesTitle = series => [series.scene, ...series.held,
  ...(series.views > 1 ? [`mean over ${series.views} views`] : []),
  ...(series.conventions === 'gsplat' ? [] : [series.conventions])].join(', ');

/// Growth of the first series of each scene and quantity.
function figuresOfGrowth(rows, files) {
  return Object.entries(scaling.quantities).flatMap(([name, quantity]) => {
    const all = scaling.series(rows, name);
    return stats.distinct(all, one => one.scene).map(scene => {
      const series = all.find(one => one.scene === scene);
      const title = [series.renderer, `${seriesTitle(series)}, ${machineOf(series, files)}`];
      return {name: `scaling-${name}-${scene}`, title, specify: look => scalingPlots.times(series, quantity, look),
              from: files[series.file]};
    });
  });
}

/// Normalised errors on hard frames, one figure for each backend, of the first image size, sort and bounds of each.
function figuresOfStress(files) {
  const rows = stress.rowsOf(files);
  const policies = row => `${row.sort}, ${row.bounds}`;
  return [...stats.groupsOf(rows, row => row.backend)].map(([backend, some]) => {
    const like = row => [choices.sizeOf, policies, one => one.file].every(key => key(row) === key(some[0]));
    const chosen = some.filter(like), file = files[some[0].file];
    const device = backend === 'cuda' ? file.machine.gpu : file.machine.cpu;
    return {name: `stability-${backend === 'cuda' ? 'gpu' : backend}`,
            title: `Error over what rounding may cost: ${choices.sizeOf(some[0])}, worst of ${some[0].seeds}, ${device}`,
            specify: look => stressPlots.normalised(stress.panels(chosen), look), from: file};
  });
}

/// The file and the commit that a figure shows, so that tests can compare them with those of tables.
function originOf({file, machine}) {
  return `<metadata>${`${file} ${machine.commit}`.replaceAll('&', '&amp;').replaceAll('<', '&lt;')}</metadata>`;
}

/// Leaves the figures in the page as base64 of SVG files, for benchmarks/figures.sh to fetch.
async function writeFigures(rows, files, stressFiles) {
  const scenes = stats.distinct(rows, row => row.scene);
  const figures = [...scenes.flatMap(scene => figuresOfScene(scene, rows, files)), ...figuresOfGrowth(rows, files),
    ...figuresOfStress(stressFiles)];
  const stand = element('div', {id: 'figures', hidden: true}, '\n');
  for (const {name, title, specify, from} of figures) {
    const svg = (await charts.svgOf(specify, title)).replace(/<\/svg>$/, () => originOf(from) + '</svg>');
    const bytes = new TextEncoder().encode(svg);
    const text = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
    stand.append(element('p', {'data-figure': name.replaceAll(/[^A-Za-z0-9_.-]+/g, '-')}, text), '\n');
  }
  document.body.append(stand);
}
