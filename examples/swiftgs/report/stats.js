// SPDX-License-Identifier: Apache-2.0
'use strict';

// Everything that the page computes from rows of result files, without a document. Durations are in milliseconds,
// errors in decibels of PSNR: Infinity where nothing differs, null where nothing was measured.
const stats = (() => {
  const durations = ['project', 'sort', 'raster', 'total', 'wall'];
  const stages = ['project', 'sort', 'raster'];

  const sum = values => values.reduce((a, b) => a + b, 0);
  const mean = values => sum(values) / values.length;

  /// The values that are numbers, infinite ones among them.
  const known = values => values.filter(value => typeof value === 'number');
  const meanOfKnown = values => known(values).length ? mean(known(values)) : null;

  /// JSON has no infinity: equal images have null for PSNR, and 0 for the largest difference.
  function psnrOf(row) {
    if (typeof row.psnr_db === 'number') return row.psnr_db;
    return row.max_abs === 0 ? Infinity : null;
  }

  /// PSNR of all images as if they were one: that of the mean squared error. null without any.
  function meanPsnr(values) {
    if (!known(values).length) return null;
    return -10 * Math.log10(mean(known(values).map(value => 10 ** (-value / 10)))) || 0;
  }

  /// Scene, number of Gaussians and enlargement.
  const caseOf = row => [row.scene, row.gaussians, row.enlarge].join('|');

  /// Rows of all files, each with its file's index, its PSNR as a number or null, and whether its scene is `whole`:
  /// with the Gaussians of the file, as large as there.
  function rowsOf(files) {
    return files.flatMap((file, index) => {
      const isWhole = scene => scene.gaussians === scene.original && scene.enlarge === 1;
      const whole = new Set(file.scenes.filter(isWhole).map(caseOf));
      return file.rows.map(row => ({...row, file: index, psnr: psnrOf(row), whole: whole.has(caseOf(row))}));
    });
  }

  /// The different values of `key`, a function of rows, in the order in which they come.
  const distinct = (rows, key) => [...new Set(rows.map(key))];

  function groupsOf(rows, key) {
    const groups = new Map();
    for (const row of rows) {
      const name = key(row);
      if (!groups.has(name)) groups.set(name, []);
      groups.get(name).push(row);
    }
    return groups;
  }

  /// Of every renderer in each file the rows with the most threads.
  function withMostThreads(rows) {
    const most = new Map();
    const key = row => row.file + '|' + row.renderer;
    for (const row of rows) most.set(key(row), Math.max(most.get(key(row)) ?? 0, row.threads));
    return rows.filter(row => row.threads === most.get(key(row)));
  }

  /// The mean of medians; its interval from theirs, as those of independent measurements. The limits are null
  /// where one has none.
  function meanDuration(list) {
    const median = mean(list.map(one => one.median));
    const reach = side => list.every(one => typeof one[side] === 'number') ?
        Math.sqrt(sum(list.map(one => (one[side] - one.median) ** 2))) / list.length : null;
    const low = reach('low'), high = reach('high');
    return {median, low: low === null ? null : median - low, high: high === null ? null : median + high};
  }

  /// What `rows` of one renderer give together: means over views, and the worst of the largest differences.
  /// `bytes` is what processes and devices grew by.
  function meanOf(rows) {
    const first = rows[0];
    const ms = Object.fromEntries(durations.map(name => [name, meanDuration(rows.map(row => row.ms[name]))]));
    const differences = known(rows.map(row => row.max_abs));
    const of = name => meanOfKnown(rows.map(row => row[name]));
    const device = of('device_bytes'), host = of('host_bytes');
    return {
      file: first.file, renderer: first.renderer, backend: first.backend, sort: first.sort, raster: first.raster,
      bounds: first.bounds, threads: first.threads, views: rows.length, ms,
      psnr: meanPsnr(rows.map(row => row.psnr)), ssim: of('ssim'),
      max_abs: differences.length ? Math.max(...differences) : null,
      measured: known(rows.map(row => row.psnr)).length,
      visible: of('visible'), intersections: of('intersections'), contributing_pairs: of('contributing_pairs'),
      bytes: device === null && host === null ? null : (device ?? 0) + (host ?? 0),
    };
  }

  /// One record for each renderer of each file and number of threads.
  function records(rows) {
    return [...groupsOf(rows, row => [row.file, row.threads, row.renderer].join('|')).values()].map(meanOf);
  }

  /// Those that a logarithmic axis of time and one of PSNR can show.
  const withError = list => list.filter(record => record.psnr !== null && record.ms.total.median > 0);

  /// A slower record has to be more exact by this much to be worth its time, in decibels.
  const worth = 1;

  /// The records that are worth their time: none of those at most as slow is as exact within `worth`, and equals share
  /// a place. Quickest first.
  function pareto(list) {
    const time = record => record.ms.total.median;
    const sorted = withError(list).sort((a, b) => time(a) - time(b) || b.psnr - a.psnr);
    let best = -Infinity, last = null;
    return sorted.filter(record => {
      const equal = last !== null && record.psnr === last.psnr && time(record) === time(last);
      if (!equal && !(record.psnr > best && record.psnr >= best + worth)) return false;
      best = record.psnr, last = record;
      return true;
    });
  }

  /// The record in `list` that another is compared with: the same file and backend, other words as given.
  function baselineOf(record, list, words) {
    return list.find(other => other.file === record.file && other.backend === record.backend &&
        other.threads === record.threads && [other.sort, other.raster, other.bounds].join('/') === words) ?? null;
  }

  /// How many times quicker than the baseline `words`, null where that was not measured.
  function speedup(record, list, words) {
    const baseline = baselineOf(record, list, words);
    return baseline && record.ms.total.median > 0 ? baseline.ms.total.median / record.ms.total.median : null;
  }

  return {durations, stages, mean, rowsOf, distinct, groupsOf, caseOf, withMostThreads, records, withError, worth,
          pareto, speedup};
})();
