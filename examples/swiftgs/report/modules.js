// SPDX-License-Identifier: Apache-2.0
'use strict';

// Vega comes in modules that ask for each other by `define`. Each is registered under `modules.next`, set before
// it, and made when `modules.get` asks for it first.
const modules = {
  next: '',
  waiting: new Map(),
  made: new Map(),

  get(asked) {
    const name = asked === 'vega-selections' ? 'vega-selection' : asked;
    if (modules.made.has(name)) return modules.made.get(name);
    if (!modules.waiting.has(name)) throw new Error(`the module ${name} is not in this page`);
    const {needs, make} = modules.waiting.get(name);
    const exported = {};
    modules.made.set(name, exported);
    make(...needs.map(need => need === 'exports' ? exported : modules.get(need)));
    return exported;
  },
};

function define(needs, make) {
  modules.waiting.set(modules.next, {needs, make});
}
define.amd = true;
