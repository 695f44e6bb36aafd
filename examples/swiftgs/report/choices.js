// SPDX-License-Identifier: Apache-2.0
'use strict';

// Which rows the page shows: one step after the other narrows them, and offers what is left. No document is needed.
const choices = (() => {
  /// Chosen where a step takes all of its values.
  const all = 'all';

  const sizeOf = row => `${row.width}×${row.height}`;
  const sceneTitle = row => `${row.scene}, ${format.count(row.gaussians)} Gaussians` +
      (row.enlarge === 1 ? '' : `, enlarged ×${row.enlarge}`);

  /// `key` is what a step chooses; `all` the title of the choice of all, where there is one, and the default then;
  /// else `first` finds the row with the default.
  const stepsFor = files => [
    {name: 'file', title: 'File', key: row => row.file, text: row => files[row.file].file, all: 'all'},
    {name: 'scene', title: 'Scene', key: stats.caseOf, text: sceneTitle, first: rows => rows.find(row => row.whole)},
    {name: 'scale', title: 'Image scale', key: row => row.scale, text: row => `${row.scale} (${sizeOf(row)})`,
     first: rows => rows.find(row => row.scale === 1)},
    {name: 'conventions', title: 'Conventions', key: row => row.conventions, text: row => row.conventions,
     first: () => undefined},
    {name: 'threads', title: 'Threads', key: row => row.threads, text: row => String(row.threads), all: 'most of each',
     take: stats.withMostThreads},
    {name: 'view', title: 'View', key: row => row.view, text: row => row.view, all: 'mean over views'},
    {name: 'backend', title: 'Backend', key: row => row.backend, text: row => row.backend, all: 'all'},
  ];

  /// Narrows `rows` by `wanted`, {step: value}; where a value is not on offer the default is taken.
  /// Gives {rows, steps}: each step with its `options`, {value, title}, and the one that is `chosen`.
  function narrow(rows, files, wanted) {
    let left = rows;
    const steps = stepsFor(files).map(step => {
      const examples = new Map(left.map(row => [String(step.key(row)), row]).reverse());
      const values = stats.distinct(left, row => String(step.key(row)));
      const options = values.map(value => ({value, title: step.text(examples.get(value))}));
      if (step.all && values.length > 1) options.unshift({value: all, title: step.all});
      const fallback = step.all ? options[0].value : String(step.key(step.first(left) ?? left[0]));
      const chosen = options.some(option => option.value === wanted[step.name]) ? wanted[step.name] : fallback;
      if (chosen !== all) left = left.filter(row => String(step.key(row)) === chosen);
      else if (step.take) left = step.take(left);
      return {name: step.name, title: step.title, options, chosen};
    });
    return {rows: left, steps};
  }

  /// Records of rows with names for plots: `label` is the renderer, `short` without its backend, and `among` the
  /// records that it may be compared with. Where a renderer is there twice, its file or threads tell them apart.
  function recordsOf(rows, files) {
    const list = stats.records(rows);
    const together = stats.groupsOf(list, record => record.renderer);
    for (const record of list) {
      const twins = together.get(record.renderer);
      const several = key => new Set(twins.map(key)).size > 1;
      const more = (several(twin => twin.file) ? ` · ${files[record.file].file}` : '') +
          (several(twin => twin.threads) ? ` · ${record.threads} threads` : '');
      record.words = [record.sort, record.raster, record.bounds].join('/');
      record.label = record.renderer + more, record.short = record.words + more;
      record.among = list;
    }
    return list;
  }

  /// Records of one file and backend together, with a title. Numbers of threads stand side by side: labels tell them apart.
  function panels(list, files) {
    const place = record => style.inOrder(list.map(one => one.backend)).indexOf(record.backend);
    const ordered = [...list].sort((a, b) => place(a) - place(b) || a.file - b.file);
    const groups = stats.groupsOf(ordered, record => [record.file, record.backend].join('|'));
    const several = new Set(list.map(record => record.file)).size > 1;
    return [...groups.values()].map(records => (
      {title: records[0].backend + (several ? `, ${files[records[0].file].file}` : ''), records}));
  }

  /// What others are compared with: gsplat's combination, or INRIA's, or the first there is.
  const usualBaselines = ['standard/per-pixel/opacity-box', 'standard/per-pixel/three-sigma-square'];
  function baselines(list) {
    const words = new Set(list.map(record => record.words));
    const usual = usualBaselines.filter(one => words.has(one));
    return [...usual, ...[...words].filter(one => !usual.includes(one)).sort()];
  }

  /// The quickest records, and the usual baselines wherever they stand, called by their short names.
  function quickest(records, count) {
    const sorted = [...records].sort((a, b) => a.ms.total.median - b.ms.total.median);
    return sorted.filter((record, i) => i < count || usualBaselines.includes(record.words))
      .map(record => ({...record, label: record.short}));
  }

  return {sizeOf, sceneTitle, narrow, recordsOf, panels, baselines, quickest};
})();
