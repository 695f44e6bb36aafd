// SPDX-License-Identifier: Apache-2.0
'use strict';

// Growth on log axes: what was measured, and the fitted lines.
const scalingPlots = (() => {
  /// With two digits and a minus sign; zero has none.
  const exponentText = fit => fit.exponent.toFixed(2).replace(/^-0.00$/, '0.00').replace('-', '−');

  /// The curves `names` of one series from scaling.js; `scaled` turns what they hold into what the axis shows.
  function curves(series, quantity, names, axis, look) {
    const {theme} = look;
    const shown = names.filter(name => series.points.some(point => point[name] > 0));
    const label = name => series.fits[name] ? `${name}: exponent ${exponentText(series.fits[name])}` : name;
    const values = shown.flatMap(name => series.points.filter(point => point[name] > 0).map(point => {
      const y = axis.scaled(point[name]);
      return {name: label(name), x: point.x, y,
              tip: {title: name, [quantity.unit]: format.count(point.x), [axis.unit]: format.short(y)}};
    }));
    const ends = [series.points[0].x, series.points[series.points.length - 1].x];
    const fits = shown.filter(name => series.fits[name]).flatMap(name => ends.map(x => (
      {name: label(name), x, y: axis.scaled(series.fits[name].factor * x ** series.fits[name].exponent)})));
    const x = plots.logDomain(ends), y = plots.logDomain([...values, ...fits].map(value => value.y));
    const labels = shown.map(label);
    const at = {x: {scale: 'x', field: 'x'}, y: {scale: 'y', field: 'y'}, stroke: {scale: 'colour', field: 'name'}};
    const byName = (data, mark) =>
      ({type: 'group', from: {facet: {data, name: 'one', groupby: 'name'}}, marks: [mark]});
    return {
      ...plots.base(look, `${axis.title} against ${quantity.unit} of ${series.renderer}`, 300),
      data: [{name: 'measured', values}, {name: 'fitted', values: fits}],
      scales: [
        {name: 'x', type: 'log', domain: x, range: 'width', nice: false},
        {name: 'y', type: 'log', domain: y, range: 'height', nice: false},
        {name: 'colour', type: 'ordinal', domain: labels, range: shown.map(name => theme.stages[name.split(' ')[0]])},
      ],
      axes: [
        {orient: 'bottom', scale: 'x', title: `${quantity.title} (log)`, grid: true, format: '~s',
         values: plots.logTicks(x, look.narrow ? 5 : 8)},
        {orient: 'left', scale: 'y', title: `${axis.title} (log)`, grid: true, format: '~g',
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

  const time = {title: 'ms a frame', unit: 'ms', scaled: value => value};
  const memory = {title: 'Memory, MiB', unit: 'MiB', scaled: value => value / 2 ** 20};

  return {
    times: (series, quantity, look) => curves(series, quantity, ['project', 'sort', 'raster', 'total'], time, look),
    memory: (series, quantity, look) => curves(series, quantity, series.memoryCurves, memory, look),
  };
})();
