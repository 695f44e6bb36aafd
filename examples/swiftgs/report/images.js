// SPDX-License-Identifier: Apache-2.0
'use strict';

/// Frames beside the reference: one over the other with a slider between them, and the error map with its legend.
/// `pairs` are {label, frame, reference, error, width, height, planes}, of which `reference` and `error` may be null;
/// `planes` are {plane, source}, the frame's other planes as pictures.
function imagePairs(pairs) {
  const stand = element('div', {class: 'stand'});
  const slider = element('input', {type: 'range', min: 0, max: 100, value: 50, class: 'slider'});
  const sliderLine = element('label', {class: 'wide'}, 'Reference on the left, frame on the right ', slider);
  const choice = element('select', {}, ...pairs.map((pair, i) => element('option', {value: i}, pair.label)));
  const modes = element('select');
  const legend = element('div', {class: 'error-legend', role: 'img',
    'aria-label': 'Largest difference of a channel: black 1e-7 or less, white 1, on a logarithmic scale'},
    element('div', {class: 'ramp'}),
    element('div', {class: 'ticks', 'aria-hidden': 'true'}, ...[7, 6, 5, 4, 3, 2, 1, 0].map(
      power => element('span', {}, power === 0 ? '1' : `1e-${power}`))));

  const picture = (source, alt, name) => element('img', {src: source, alt, class: name});

  function cut() {
    const over = stand.querySelector('.over');
    if (over) over.style.clipPath = `inset(0 0 0 ${slider.value}%)`;
    stand.style.setProperty('--cut', slider.value + '%');
  }

  function show() {
    const pair = pairs[choice.value], mode = modes.value;
    stand.style.aspectRatio = `${pair.width} / ${pair.height}`;
    stand.className = 'stand ' + mode;
    const frame = picture(pair.frame, `Frame of ${pair.label}`, 'over');
    const reference = pair.reference && picture(pair.reference, 'Reference in float64', 'under');
    const shown = {slider: [reference, frame], frame: [frame], reference: [reference],
                   error: [pair.error && picture(pair.error, `Error map of ${pair.label}`, 'under')]};
    for (const {plane, source} of pair.planes)
      shown[plane] = [picture(source, `${plane} of ${pair.label}`, 'under')];
    stand.replaceChildren(...shown[mode]);
    sliderLine.hidden = mode !== 'slider';
    legend.hidden = mode !== 'error';
    if (mode === 'slider') cut();
  }

  /// The ways to look at a pair that its images allow; the one that was chosen stays where it can.
  function choose() {
    const pair = pairs[choice.value], before = modes.value;
    const ways = [['slider', 'slider', pair.reference], ['frame', 'frame', true],
                  ['reference', 'reference', pair.reference], ['error', 'error map', pair.error],
                  ...pair.planes.map(({plane}) => [plane, plane.replaceAll('_', ' '), true])]
      .filter(([, , there]) => there);
    modes.replaceChildren(...ways.map(([value, title]) => element('option', {value}, title)));
    if (ways.some(([value]) => value === before)) modes.value = before;
    show();
  }

  choice.addEventListener('change', choose);
  modes.addEventListener('change', show);
  slider.addEventListener('input', cut);
  choose();
  return element('div', {}, element('div', {class: 'choosers'}, element('label', {}, 'Image ', choice),
    element('label', {}, 'Show ', modes)), sliderLine, stand, legend);
}
