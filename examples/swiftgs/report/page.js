// SPDX-License-Identifier: Apache-2.0
'use strict';

// The page: headings of the files, what is chosen, and the sections that have something to show.
const page = (() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const rows = stats.rowsOf(data.files);
  const wanted = {baseline: '', bounds: ''};

  const find = (selector, root = document) => root.querySelector(selector);

  /// A labelled chooser of `options`, {value, title}; nothing where there is only one.
  function chooser(title, options, chosen, choose) {
    if (options.length < 2) return [];
    const select = element('select', {onchange: event => { choose(event.target.value); render(); }},
      ...options.map(({value, title: text}) => element('option', {value, selected: value === chosen}, text)));
    return [element('label', {}, title, select)];
  }

  const simple = values => values.map(value => ({value, title: value}));

  /// Replaces choosers, and gives the focus back to the one that had it.
  function setChoosers(place, labels) {
    const focused = [...place.querySelectorAll('select')].indexOf(document.activeElement);
    const title = focused < 0 ? null : document.activeElement.parentElement.firstChild.textContent;
    place.replaceChildren(...labels);
    for (const label of labels)
      if (label.firstChild.textContent === title) find('select', label).focus();
  }

  function showMachines() {
    find('#machines').replaceChildren(...[...data.files, ...data.stress].map(file => {
      const {machine} = file;
      const gpu = machine.gpu && [machine.gpu, machine.gpu_memory_gib && `${machine.gpu_memory_gib} GiB`,
        machine.driver && `driver ${machine.driver}`, machine.cuda && `CUDA ${machine.cuda}`]
        .filter(Boolean).join(', ');
      const lines = {
        date: machine.date, GPU: gpu,
        CPU: [machine.cpu, machine.cores && `${machine.cores} cores`, machine.memory_gib && `${machine.memory_gib} GiB`]
          .filter(Boolean).join(', '),
        system: machine.system, compiler: [machine.compiler, machine.flags].filter(Boolean).join('  '),
        commit: [machine.commit, machine.version && `version ${machine.version}`].filter(Boolean).join(', '),
        'load before': machine.load,
      };
      const known = Object.entries(lines).filter(([, text]) => text !== undefined && text !== '' && text !== null);
      return element('article', {class: 'machine'}, element('h2', {}, file.file), element('dl', {},
        ...known.flatMap(([name, text]) => [element('dt', {}, name), element('dd', {}, String(text))]),
        element('dt', {}, 'command'), element('dd', {}, element('code', {}, file.command))));
    }));
  }

  const ms = (name, of = record => record.ms[name].median) =>
    ({title: `${name} ms`, number: true, value: of, text: row => format.short(of(row))});
  const number = (title, value, text = format.short) => ({title, number: true, value, text: row => text(value(row))});
  const word = (title, value) => ({title, value});
  /// Columns in which some row has something.
  const filled = (columns, list) => columns.filter(column => list.some(row => (column.value(row) ?? null) !== null));

  const recordColumns = list => filled([
    word('renderer', record => record.label), ms('project'), ms('sort'), ms('raster'), ms('total'), ms('wall'),
    number('speed-up', record => stats.speedup(record, record.among, wanted.baseline)),
    number('PSNR dB', record => record.psnr, format.psnr), number('SSIM', record => record.ssim, format.ssim),
    number('largest error', record => record.max_abs), number('visible', record => record.visible, format.count),
    number('intersections', record => record.intersections, format.count),
    number('blended pairs', record => record.contributing_pairs, format.count),
    number('memory', record => record.bytes, format.bytes),
  ], list);

  function showPareto(list) {
    const section = find('#pareto');
    const known = stats.withError(list);
    section.hidden = known.length === 0;
    if (section.hidden) return;
    const front = stats.pareto(known);
    charts.draw(find('.chart', section), look => plots.pareto(known, front, look));
    const left = list.length - known.length;
    find('.note', section).textContent = 'Over several views PSNR is that of the mean squared error. ' +
      `A slower renderer is on the front if it is more exact by ${stats.worth} dB or more.` +
      (left === 1 ? ' One renderer without a measured error is not in this plot.' : '') +
      (left > 1 ? ` ${left} renderers without a measured error are not in this plot.` : '');
    find('.list', section).replaceChildren(sortableTable({
      caption: 'On the Pareto front',
      columns: [number('', record => front.indexOf(record) + 1, String), ...recordColumns(front)], rows: front}));
  }

  /// One chart for each panel; places stay while their number stays, so that nothing jumps.
  function showPanels(section, panels, specify) {
    const place = find('.charts', section);
    if (place.children.length !== panels.length)
      place.replaceChildren(...panels.map(() => element('div', {}, element('h3'), element('div', {class: 'chart'}))));
    panels.forEach((panel, i) => {
      find('h3', place.children[i]).textContent = panel.title;
      charts.draw(find('.chart', place.children[i]), look => specify(panel, look));
    });
  }

  function showStages(list) {
    const section = find('#stages');
    section.hidden = false;
    const panels = choices.panels(list, data.files);
    showPanels(section, panels, (panel, look) => bars.stagesStacked(choices.quickest(panel.records, 20), look));
  }

  function showSpeedups(list) {
    const section = find('#speedups');
    const words = choices.baselines(list);
    if (!words.includes(wanted.baseline)) wanted.baseline = words[0];
    const compared = list.filter(record => stats.speedup(record, list, wanted.baseline) !== null);
    section.hidden = compared.length < 2;
    if (section.hidden) return;
    const bounds = style.inOrder(compared.map(record => record.bounds));
    if (!bounds.includes(wanted.bounds)) wanted.bounds = bounds[bounds.length - 1];
    setChoosers(find('.choosers', section), [
      ...chooser('Baseline', simple(words), wanted.baseline, value => wanted.baseline = value),
      ...chooser('Bounds', simple(bounds), wanted.bounds, value => wanted.bounds = value),
    ]);
    const panels = choices.panels(compared.filter(record => record.bounds === wanted.bounds), data.files);
    showPanels(section, panels, (panel, look) => bars.speedups(panel.records, wanted.baseline, look));
  }

  function showGrowth() {
    const section = find('#growth');
    const figures = [...figuresOfGrowth(rows, data.files), ...figuresOfStress(data.stress)];
    section.hidden = figures.length === 0;
    const titled = figures.map(figure => ({...figure, title: [figure.title].flat().join(', ')}));
    showPanels(section, titled, (figure, look) => figure.specify(look));
  }

  function summaryOf(list) {
    const range = values => {
      const low = Math.min(...values), high = Math.max(...values);
      return (low === high ? String(low) : `${low} to ${high}`) + (high === 1 ? ' view' : ' views');
    };
    const measured = list.map(record => record.measured).filter(Boolean);
    return `${list.length} renderers; times over ${range(list.map(record => record.views))}` +
      (measured.length ? `, errors over ${range(measured)}.` : ', no errors measured.');
  }

  function render() {
    const {rows: chosen, steps} = choices.narrow(rows, data.files, wanted);
    setChoosers(find('#choosers'), steps.flatMap(
      step => chooser(step.title, step.options, step.chosen, value => wanted[step.name] = value)));
    const list = choices.recordsOf(chosen, data.files);
    find('#summary').textContent = summaryOf(list);
    showSpeedups(list);
    showPareto(list);
    showStages(list);
    find('#means').replaceChildren(sortableTable({
      caption: 'Renderers, as chosen above', columns: recordColumns(list), rows: list, filter: true, sort: 4}));
    find('#missing').textContent = [
      ...(find('#pareto').hidden ? ['errors against float64'] : []),
      ...(find('#speedups').hidden ? ['a baseline'] : []),
    ].map((text, i) => (i === 0 ? 'Not in these files: ' : '') + text).join('; ');
    charts.refresh();
  }

  showMachines();
  find('#tables').hidden = find('#choosers').hidden = find('#summary').hidden = rows.length === 0;
  if (rows.length > 0) render();
  showGrowth();
  charts.refresh();
  if (location.hash === '#figures') writeFigures(rows, data.files, data.stress);
})();
