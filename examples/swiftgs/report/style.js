// SPDX-License-Identifier: Apache-2.0
'use strict';

// Numbers as texts, and the colours and shapes of plots.
const format = (() => {
  /// Three digits that count, as 0.0123, 1.23, 123 or 12345.
  function short(value) {
    if (value === null || value === undefined) return '–';
    if (!Number.isFinite(value)) return value > 0 ? '∞' : '–';
    if (value === 0) return '0';
    const size = Math.floor(Math.log10(Math.abs(value)));
    return size < -4 ? value.toExponential(1) : value.toFixed(Math.max(0, 2 - size));
  }

  function count(value) {
    if (value === null || value === undefined) return '–';
    for (const [limit, unit] of [[1e9, ' G'], [1e6, ' M'], [1e3, ' k']])
      if (Math.abs(value) >= limit) return Number((value / limit).toPrecision(3)) + unit;
    return String(Number(value.toPrecision(3)));
  }

  function bytes(value) {
    if (value === null || value === undefined) return '–';
    return value >= 2 ** 30 ? short(value / 2 ** 30) + ' GiB' : short(value / 2 ** 20) + ' MiB';
  }

  const psnr = value => value === null ? '–' : value === Infinity ? '∞' : value.toFixed(2);
  /// What is short of 1 is what matters.
  const ssim = value => value === null ? '–' : value.toFixed(6);
  return {short, count, bytes, psnr, ssim};
})();

const style = (() => {
  const theme = {
    background: '#ffffff', text: '#1f2328', quiet: '#59636e', line: '#d9dee3', mark: '#1f2328',
    rasters: {'per-pixel': '#6e7781',
              'axis-shared-half-split': '#f0883e', 'axis-shared-float-split': '#6ea8fe',
              'axis-shared-float-cholesky': '#4fbf9f', 'axis-shared-threshold-half-split': '#b3470b',
              'axis-shared-threshold-float-split': '#1556c0', 'axis-shared-threshold-float-cholesky': '#00704f'},
    stages: {project: '#8e6bbf', sort: '#e0a030', raster: '#2b7fc4', total: '#1f2328'},
  };
  /// For words that have no colour of their own.
  const others = ['#d03a9c', '#a08000', '#7a5af5', '#00889a', '#c03030'];
  const shapes = {
    'three-sigma-square': 'square', 'opacity-box': 'diamond', ellipse: 'circle',
    standard: 'triangle-up', early: 'circle', adaptive: 'cross',
  };
  const otherShapes = ['triangle-down', 'triangle-left', 'triangle-right', 'stroke'];
  const order = [...Object.keys(theme.rasters), 'standard', 'early', 'adaptive',
                 'three-sigma-square', 'opacity-box', 'ellipse', 'cuda', 'cpu', 'serial'];

  /// The words of a kind in a fixed order, unknown ones last.
  function inOrder(words) {
    const place = word => order.includes(word) ? order.indexOf(word) : order.length;
    return [...new Set(words)].sort((a, b) => place(a) - place(b) || (a < b ? -1 : 1));
  }

  /// One value for each word: its own, or one of `spare` in turn.
  function assign(words, own, spare) {
    let used = 0;
    return words.map(word => own[word] ?? spare[used++ % spare.length]);
  }

  return {
    theme, inOrder,
    colours: words => assign(words, theme.rasters, others),
    shapes: words => assign(words, shapes, otherShapes),
  };
})();
