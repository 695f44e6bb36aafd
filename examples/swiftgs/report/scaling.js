// SPDX-License-Identifier: Apache-2.0
'use strict';

// How time grows with one quantity while the others are held: series of points, and exponents fitted to them.
// No document is needed here.
const scaling = (() => {
  const curves = [...stats.stages, 'total'];
  const tileSide = 16;
  const tilesOf = row => Math.ceil(row.width / tileSide) * Math.ceil(row.height / tileSide);

  /// `level` is what the run varied; `value` what a point is drawn at; `held` what must not change.
  const quantities = {
    gaussians: {
      title: 'Gaussians', unit: 'Gaussians', level: row => row.gaussians, value: row => row.gaussians,
      held: ['enlarge', 'scale', 'width', 'height', 'threads'],
    },
    pixels: {
      title: 'Pixels', unit: 'pixels', level: row => row.scale, value: row => row.width * row.height,
      held: ['gaussians', 'enlarge', 'threads'],
    },
    threads: {
      title: 'Threads', unit: 'threads', level: row => row.threads, value: row => row.threads,
      held: ['gaussians', 'enlarge', 'scale', 'width', 'height'],
      // The threads of the host say nothing of a GPU, and nothing of what uses one alone.
      applies: row => row.backend !== 'cuda' && row.backend !== 'serial',
    },
    occupancy: {
      title: 'Intersections a tile', unit: 'intersections a tile', level: row => row.enlarge,
      value: row => row.intersections / tilesOf(row),
      held: ['gaussians', 'scale', 'width', 'height', 'threads'],
      applies: row => row.intersections > 0,
    },
  };

  /// How what was held reads, of `row`.
  const heldTexts = {
    gaussians: row => `${format.count(row.gaussians)} Gaussians`,
    width: row => choices.sizeOf(row),
    threads: row => row.backend === 'cuda' ? null : row.threads === 1 ? 'one thread' : `${row.threads} threads`,
    enlarge: row => row.enlarge === 1 ? null : `enlarged ×${row.enlarge}`,
  };
  const textsOf = (row, held) => held.map(name => heldTexts[name]?.(row)).filter(Boolean);

  /// What comes first where one series is to be shown, the smaller the sooner: many points, all threads, the
  /// scene and images as they are.
  const rank = (row, points) => [-points.length, -row.threads, Math.abs(Math.log(row.enlarge)),
    Math.abs(Math.log(row.scale)), row.whole ? 0 : 1, points[points.length - 1].total];

  /// Least squares of ln y = exponent · ln x + ln factor over points [x, y]; those with a y that is no positive
  /// number are left out. null with fewer than two different x.
  function fit(points) {
    const logs = points.filter(([x, y]) => x > 0 && y > 0).map(([x, y]) => [Math.log(x), Math.log(y)]);
    if (new Set(logs.map(([x]) => x)).size < 2) return null;
    const mx = stats.mean(logs.map(([x]) => x)), my = stats.mean(logs.map(([, y]) => y));
    const across = logs.reduce((sum, [x, y]) => sum + (x - mx) * (y - my), 0);
    const exponent = across / logs.reduce((sum, [x]) => sum + (x - mx) ** 2, 0);
    return {exponent, factor: Math.exp(my - exponent * mx)};
  }

  function pointOf(rows, value) {
    const [record] = stats.records(rows);
    const point = {x: stats.mean(rows.map(value))};
    for (const curve of curves) point[curve] = record.ms[curve].median;
    return point;
  }

  /// One series from rows that differ in level and view alone, over the views that all levels have; null with
  /// fewer than three values.
  function seriesOf(rows, quantity) {
    const levels = stats.groupsOf(rows, quantity.level);
    const views = [...levels.values()].map(some => new Set(some.map(row => row.view)));
    const shared = [...views[0]].filter(view => views.every(set => set.has(view)));
    if (levels.size < 3 || !shared.length) return null;
    const points = [...levels.values()].map(
      some => pointOf(some.filter(row => shared.includes(row.view)), quantity.value)).sort((a, b) => a.x - b.x);
    if (new Set(points.map(point => point.x)).size < 3) return null;
    const fits = {};
    for (const curve of curves) fits[curve] = fit(points.map(point => [point.x, point[curve]]));
    const {file, scene, conventions, renderer, backend} = rows[0];
    return {file, scene, conventions, renderer, backend, views: shared.length, points, fits,
            held: textsOf(rows[0], quantity.held), rank: rank(rows[0], points)};
  }

  function compareRanks(a, b) {
    const at = a.rank.findIndex((value, i) => value !== b.rank[i]);
    return at < 0 ? 0 : a.rank[at] - b.rank[at];
  }

  /// All series of a quantity, by its name in `quantities`: the most usual and quickest first.
  function series(rows, name) {
    const quantity = quantities[name];
    const fitting = quantity.applies ? rows.filter(quantity.applies) : rows;
    const key = row => [row.file, row.scene, row.conventions, row.renderer, ...quantity.held.map(held => row[held])].join('|');
    return [...stats.groupsOf(fitting, key).values()].map(group => seriesOf(group, quantity)).filter(Boolean)
      .sort(compareRanks);
  }

  return {curves, quantities, series};
})();
