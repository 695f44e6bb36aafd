// SPDX-License-Identifier: Apache-2.0
'use strict';

// Growth on log axes: what was measured, and the fitted lines.
const scalingPlots = (() => {
  /// With two digits and a minus sign; zero has none.
  const exponentText = fit => fit.exponent.toFixed(2).replace(/^-0.00$/, '0.00').replace('-', '−');

  /// The times of one series from scaling.js.
  function times(series, quantity, look) {
    const shown = scaling.curves.filter(name => series.points.some(point => point[name] > 0));
    const label = name => series.fits[name] ? `${name}: exponent ${exponentText(series.fits[name])}` : name;
    const values = shown.flatMap(name => series.points.filter(point => point[name] > 0).map(point => (
      {name: label(name), x: point.x, y: point[name],
       tip: {title: name, [quantity.unit]: format.count(point.x), ms: format.short(point[name])}})));
    const ends = [series.points[0].x, series.points[series.points.length - 1].x];
    const fits = shown.filter(name => series.fits[name]).flatMap(name => ends.map(x => (
      {name: label(name), x, y: series.fits[name].factor * x ** series.fits[name].exponent})));
    const x = plots.logDomain(ends), y = plots.logDomain([...values, ...fits].map(value => value.y));
    const labels = shown.map(label);
    const at = {x: {scale: 'x', field: 'x'}, y: {scale: 'y', field: 'y'}, stroke: {scale: 'colour', field: 'name'}};
    const byName = (data, mark) =>
      ({type: 'group', from: {facet: {data, name: 'one', groupby: 'name'}}, marks: [mark]});
    return {
      ...plots.base(look, `ms a frame against ${quantity.unit} of ${series.renderer}`, 300),
      data: [{name: 'measured', values}, {name: 'fitted', values: fits}],
      scales: [
        {name: 'x', type: 'log', domain: x, range: 'width', nice: false},
        {name: 'y', type: 'log', domain: y, range: 'height', nice: false},
        {name: 'colour', type: 'ordinal', domain: labels, range: shown.map(name => style.theme.stages[name])},
      ],
      axes: [
        {orient: 'bottom', scale: 'x', title: `${quantity.title} (log)`, grid: true, format: '~s',
         values: plots.logTicks(x, 8)},
        {orient: 'left', scale: 'y', title: 'ms a frame (log)', grid: true, format: '~g',
         values: plots.logTicks(y, 9)},
      ],
      legends: [plots.legend(look, 2, {stroke: 'colour', symbolType: 'stroke', symbolStrokeWidth: 3})],
      marks: [
        byName('fitted', {type: 'line', name: 'fits', interactive: false, from: {data: 'one'},
          encode: {update: {...at, strokeDash: {value: [5, 4]}, strokeOpacity: {value: 0.7}}}}),
        byName('measured', {type: 'line', name: 'curves', interactive: false, from: {data: 'one'},
          encode: {update: {...at, strokeWidth: {value: 2}}}}),
        {type: 'symbol', name: 'points', from: {data: 'measured'},
         encode: {update: {...at, fill: {scale: 'colour', field: 'name'}, size: {value: 50}, tooltip: {field: 'tip'}},
                  hover: {size: {value: 110}}}},
      ],
    };
  }

  return {times};
})();
