// SPDX-License-Identifier: Apache-2.0

// Checks of the page's arithmetic with rows whose answers are known. `tell` hands what is wrong to the test.
const wrong = [];
let count = 0;
function expect(what, found, expected) {
  ++count;
  const close = (a, b) => a === b || Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(b)) ||
    (typeof a === 'object' && a !== null && b !== null && Object.keys(b).every(key => close(a[key], b[key])) &&
     (!Array.isArray(b) || a.length === b.length));
  if (!close(found, expected)) wrong.push(`${what}: expected ${JSON.stringify(expected)}, found ${JSON.stringify(found)}`);
}

const duration = (median, reach = 0.1) => ({median, low: median - reach, high: median + reach, p10: median, p90: median});
function row(more) {
  const renderer = more.renderer ?? 'cpu/early/per-pixel/ellipse', [backend, sort, raster, bounds] = renderer.split('/');
  const {project = 1, sorting = 2, rastering = 3, total = project + sorting + rastering} = more;
  return {scene: 's', gaussians: 1000, enlarge: 1, view: 'a', width: 160, height: 160, scale: 1, conventions: 'gsplat', threads: 4,
          renderer, backend, sort, raster, bounds, frames: 9, psnr_db: 100, max_abs: 1e-3, ssim: 1, visible: 10, intersections: 5000,
          contributing_pairs: 3, device_bytes: 0, host_bytes: 100, ...more,
          ms: {project: duration(project), sort: duration(sorting), raster: duration(rastering), total: duration(total),
               wall: duration(total + 1)}};
}
const rowsOf = rows => stats.rowsOf([{scenes: [{scene: 's', gaussians: 1000, original: 1000, enlarge: 1}], rows}]);

// PSNR.
expect('PSNR that was measured', stats.psnrOf({psnr_db: 60, max_abs: 1}), 60);
expect('PSNR of equal images', stats.psnrOf({psnr_db: null, max_abs: 0}), Infinity);
expect('PSNR that was not measured', stats.psnrOf({psnr_db: null, max_abs: null}), null);
expect('mean of equal PSNR', stats.meanPsnr([60, 60]), 60);
expect('mean of PSNR with an exact view', stats.meanPsnr([60, Infinity]), 60 + 10 * Math.log10(2));
expect('mean of exact views', stats.meanPsnr([Infinity, Infinity]), Infinity);
expect('mean without PSNR', stats.meanPsnr([null]), null);

// Means over views.
const views = rowsOf([row({view: 'a', rastering: 3}), row({view: 'b', rastering: 5, max_abs: 0.5, psnr_db: null})]);
const [mean] = stats.records(views);
expect('mean of medians', mean.ms.raster.median, 4);
expect('interval of a mean', [mean.ms.raster.low, mean.ms.raster.high],
       [4 - 0.1 / Math.sqrt(2), 4 + 0.1 / Math.sqrt(2)]);
expect('worst difference', mean.max_abs, 0.5);
expect('views with an error', [mean.views, mean.measured], [2, 1]);
expect('no interval without limits', stats.meanDuration([{median: 2, low: null, high: null}]),
       {median: 2, low: null, high: null});
expect('scene of the file', views[0].whole, true);
expect('the most threads',
       stats.withMostThreads(rowsOf([row({threads: 1}), row({threads: 4})])).map(one => one.threads), [4]);

// The front: b is beaten by a, c is slower but more exact, d is as quick as c but less exact, e was not measured.
const front = stats.pareto([['a', 1, 60], ['b', 2, 50], ['c', 3, 100], ['d', 3, 80], ['e', 0.5, null], ['f', 9, Infinity]].map(
  ([name, total, psnr]) => ({name, psnr, ms: {total: {median: total}}})));
expect('Pareto front', front.map(one => one.name), ['a', 'c', 'f']);
const equals = stats.pareto([1, 2].map(name => ({name, psnr: 60, ms: {total: {median: 1}}})));
expect('equals share the front', equals.length, 2);
const close = stats.pareto([['a', 1, 60], ['b', 2, 60.9], ['c', 3, 61], ['d', 4, 61.5], ['e', 5, Infinity],
  ['f', 6, Infinity]].map(([name, total, psnr]) => ({name, psnr, ms: {total: {median: total}}})));
expect('a decibel is worth a place on the front', close.map(one => one.name), ['a', 'c', 'e']);

// Speed-ups.
const list = stats.records(rowsOf([row({renderer: 'cpu/standard/per-pixel/opacity-box', total: 12}), row({total: 3}),
  row({renderer: 'cuda/early/per-pixel/ellipse'})]));
expect('speed-up', stats.speedup(list[1], list, 'standard/per-pixel/opacity-box'), 4);
expect('speed-up by the wall clock', stats.speedup(list[1], list, 'standard/per-pixel/opacity-box', 'wall'), 13 / 4);
expect('no baseline of another backend', stats.speedup(list[2], list, 'standard/per-pixel/opacity-box'), null);
expect('usual baseline first', choices.baselines([{words: 'a'}, {words: 'standard/per-pixel/opacity-box'}])[0],
       'standard/per-pixel/opacity-box');

// Growth.
expect('exponent of a power', scaling.fit([[1, 2], [10, 2 * 10 ** 0.8], [100, 2 * 100 ** 0.8]]),
       {exponent: 0.8, factor: 2});
expect('least squares of logarithms', scaling.fit([[1, 1], [Math.E, Math.E ** 2], [Math.E ** 2, Math.E]]).exponent,
       0.5);
expect('no fit of one value', scaling.fit([[2, 1], [2, 3]]), null);
expect('zeros are left out', scaling.fit([[1, 0], [10, 1], [100, 10]]).exponent, 1);
const growth = (sizes, more = {}) => rowsOf(sizes.map(
  gaussians => row({gaussians, project: gaussians / 100, sorting: 20, rastering: 1, host_bytes: gaussians ** 2, ...more})));
const [grown] = scaling.series(growth([1000, 4000, 16000]), 'gaussians');
expect('exponents of stages', [grown.fits.project.exponent, grown.fits.sort.exponent, grown.fits.memory.exponent],
       [1, 0, 2]);
expect('where a stage begins to dominate', grown.dominance,
       [{stage: 'sort', from: 1000}, {stage: 'project', from: 2000}]);
expect('without bytes of stages', grown.memoryCurves, ['memory']);
const bytes = gaussians => ({project: gaussians, sort: gaussians ** 2, raster: 0});
const stored = [1000, 4000, 16000].flatMap(gaussians => growth([gaussians], {bytes: bytes(gaussians)}));
const [known] = scaling.series(stored, 'gaussians');
expect('exponents of the memory of stages',
       ['project memory', 'sort memory', 'raster memory'].map(curve => known.fits[curve]?.exponent), [1, 2, undefined]);
expect('their sum', known.points[0].memory, 1001000);
expect('one row without bytes of stages',
       scaling.series([...stored.slice(1), ...growth([1000])], 'gaussians')[0].memoryCurves, ['memory']);
expect('two values are no growth', scaling.series(growth([1000, 2000]), 'gaussians').length, 0);
expect('other things are held',
       scaling.series([...growth([1000, 2000]), ...growth([4000], {threads: 1})], 'gaussians').length, 0);
const uneven = [...growth([1000, 4000, 16000]), ...growth([1000], {view: 'b', project: 500})];
expect('views that all sizes have', scaling.series(uneven, 'gaussians')[0].fits.project.exponent, 1);
const threads = backend => rowsOf([1, 2, 4].map(count => row({threads: count, total: 8 / count, renderer: `${backend}/early/x/y`})));
expect('threads', scaling.series(threads('cpu'), 'threads')[0].fits.total.exponent, -1);
expect('threads say nothing of a GPU', scaling.series(threads('cuda'), 'threads').length, 0);
const occupied = rowsOf([1, 2, 4].map(enlarge => row({enlarge, intersections: 1000 * enlarge, sorting: enlarge ** 2})));
expect('intersections a tile', scaling.series(occupied, 'occupancy')[0].points.map(point => point.x), [10, 20, 40]);
const pixels = rowsOf([1, 2, 4].map(scale => row({scale, width: 160 * scale, height: 160 * scale, rastering: scale ** 2})));
expect('pixels', scaling.series(pixels, 'pixels')[0].fits.raster.exponent, 1);

expect('what was held', scaling.series(occupied, 'occupancy')[0].held, ['1 k Gaussians', '160×160', '4 threads']);
const several = [...growth([1000, 2000, 4000], {threads: 1}), ...growth([1000, 2000, 4000], {enlarge: 2}), ...growth([1000, 2000, 4000])];
expect('the usual series first', scaling.series(several, 'gaussians').map(one => one.held),
       [['160×160', '4 threads'], ['enlarged ×2', '160×160', '4 threads'], ['160×160', 'one thread']]);

// Choices: the whole scene in its own size first; what is not on offer becomes the default.
const offered = choices.narrow(rowsOf([row({gaussians: 500}), row({scale: 2}), row({}), row({view: 'b'})]), [{file: 'f'}],
                               {scale: '7', view: 'a'});
expect('default choices', offered.steps.map(step => step.chosen), ['0', 's|1000|1', '1', 'gsplat', '4', 'a', 'cpu']);
expect('rows of choices', offered.rows.length, 1);

// Hard frames: null is infinity but for a renderer that failed on every seed.
const hard = more => ({family: 'f', severity: 1, severity_label: 'how much', renderer: 'cpu/early/a/b', backend: 'cpu',
  raster: 'a', seeds: 2, failed: 0, strict_normalised_error: 1, normalised_error: 1, normalised_depth_error: 1, psnr_db: 90, max_abs: 1e-6, ...more});
const rowsOfStress = stress.rowsOf([{rows: [hard({severity: null, strict_normalised_error: null}), hard({psnr_db: null, max_abs: 0}),
  hard({severity: 0, failed: 2, strict_normalised_error: null, psnr_db: null, max_abs: null}), hard({family: 'g', raster: 'c'})]}]);
expect('an infinite normalised error', rowsOfStress[0].strict_normalised_error, Infinity);
expect('an infinite severity', rowsOfStress[0].severity, Infinity);
expect('PSNR of equal hard frames', rowsOfStress[1].psnr, Infinity);
expect('nothing is known of a failure', [rowsOfStress[2].strict_normalised_error, rowsOfStress[2].max_abs, rowsOfStress[2].psnr],
       [null, null, null]);
const panels = stress.panels(rowsOfStress);
expect('a panel a family', panels.map(panel => panel.family), ['f', 'g']);
expect('severities in order', panels[0].severities, [0, 1, Infinity]);
expect('a curve a renderer', panels[0].curves.map(curve => curve.points.map(row => row.severity)), [[1, Infinity]]);
expect('places on a log axis', stress.places([0, 1e2, 1e4, Infinity]).map(place => place.x), [0, 2, 4, 6]);
expect('one severity has a place', stress.places([0]).map(place => place.x), [0]);
expect('severities as texts', [0, 0.1, 100, 1e3, 1e-5, 3e38, 1e10, Infinity].map(stress.severityText),
       ['0', '0.1', '100', '1e3', '1e-5', '3e38', '1e10', '∞']);

// Numbers as texts.
expect('numbers', [0.01234, 1.2345, 123.45, 12345, 0, null, Infinity].map(format.short),
       ['0.0123', '1.23', '123', '12345', '0', '–', '∞']);
expect('counts', [950, 1500, 1514000].map(format.count), ['950', '1.5 k', '1.51 M']);
tell({count, wrong});
