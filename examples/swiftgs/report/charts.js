// SPDX-License-Identifier: Apache-2.0
'use strict';

// Draws specifications with Vega, anew when the width of the page changes.
const charts = (() => {
  const vega = (() => {
    const {transforms} = modules.get('vega-dataflow');
    for (const name of ['vega-transforms', 'vega-view-transforms', 'vega-encode'])
      Object.assign(transforms, modules.get(name));
    return {parse: modules.get('vega-parser').parse, View: modules.get('vega-view').View};
  })();
  const drawn = new Map();
  const tip = document.getElementById('tip');

  function showTip(handler, event, item, value) {
    tip.hidden = !value;
    if (!value) return;
    const {title, ...rest} = value;
    tip.replaceChildren(element('strong', {}, title), element('dl', {}, ...Object.entries(rest).flatMap(
      ([name, text]) => [element('dt', {}, name), element('dd', {}, String(text))])));
    const {width, height} = tip.getBoundingClientRect();
    tip.style.left = Math.max(4, Math.min(event.clientX + 14, innerWidth - width - 8)) + 'px';
    const below = event.clientY + 16, above = event.clientY - height - 12;
    tip.style.top = (below + height > innerHeight ? above : below) + 'px';
  }

  function drawOne(place) {
    const one = drawn.get(place);
    const width = Math.floor(place.clientWidth);
    if (width === 0) return;
    if (one.view) one.view.finalize();
    one.width = width;
    one.view = new vega.View(vega.parse(one.specify({width})), {renderer: 'svg', container: place, hover: true});
    one.view.tooltip(showTip).run();
    place.setAttribute('aria-label', one.view.description());
  }

  /// Draws in `place`, an element of the page, what `specify` makes of a look.
  function draw(place, specify) {
    drawn.set(place, {...drawn.get(place), specify});
    place.setAttribute('role', 'figure');
    drawOne(place);
  }

  /// Forgets what is no longer in the page, and draws again what has another width than before.
  function refresh() {
    for (const [place, one] of drawn) {
      if (!place.isConnected) {
        one.view?.finalize();
        drawn.delete(place);
      } else if (Math.floor(place.clientWidth) !== one.width) {
        drawOne(place);
      }
    }
  }

  let waiting = 0;
  addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(refresh, 120);
  });

  /// The text of an SVG file, with a title of its own. Places are rounded to hundredths of a pixel.
  async function svgOf(specify, title) {
    const svg = await new vega.View(vega.parse(specify({width: 900, title})), {renderer: 'none'}).toSVG();
    const rounded = number => String(Number(Number(number).toFixed(2)));
    return svg.replace(/ (?:d|transform)="[^"]*"/g, places => places.replace(/-?\d+\.\d{3,}(?!\d*e)/g, rounded));
  }

  return {draw, refresh, svgOf};
})();
