// SPDX-License-Identifier: Apache-2.0
// Draws the conformance set with viewers in headless Chromium, and judges what they draw:
//
//   node benchmarks/conformance/run.mjs OUT [VIEWER...]
//
// VIEWER is a name of `viewers` below, with @best for its most exact settings; all without one. npm installs their
// packages into OUT. OUT/VIEWER gets a canvas of each clause, NAME.rgba, and OUT/viewers.json what the judge says.
// CHROMIUM is the browser, else what Debian's package installs. PYTHON, else python3, needs NumPy. Exit code 77 says
// that npm or the browser is missing.
import { spawn, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';

// The files of viewers/: name, package, and whether settings bring it nearer to the conventions.
const viewers = {
  babylon: ['Babylon.js', '@babylonjs/core', false],
  gsplatjs: ['gsplat.js', 'gsplat', false],
  mkkellogg: ['GaussianSplats3D', '@mkkellogg/gaussian-splats-3d', true],
  playcanvas: ['PlayCanvas', 'playcanvas', true],
  spark: ['Spark', '@sparkjsdev/spark', true],
};
const here = import.meta.dirname, conformance = path.join(here, '../../tests/conformance');
const set = path.join(conformance, 'set'), manifest = JSON.parse(fs.readFileSync(path.join(set, 'manifest.json')));
const chromium = process.env.CHROMIUM ?? '/usr/bin/chromium';
const [given, ...wanted] = process.argv.slice(2);
if (!given) throw Error('run.mjs: expected the folder to write');
const out = path.resolve(given), asked = spawnSync(chromium, ['--version'], { encoding: 'utf8' });
const browserVersion = asked.stdout?.match(/Chromium \d+[.\d]*/)?.[0];
fs.mkdirSync(out, { recursive: true });
fs.copyFileSync(path.join(here, 'package.json'), path.join(out, 'package.json'));
const npm = spawnSync('npm', ['install', '--prefix', out, '--no-audit', '--no-fund'], { stdio: 'ignore' });
if (!browserVersion || npm.status !== 0) {
  console.log(`skipped: ${browserVersion ? 'npm installs nothing here' : `no browser ${chromium} (package chromium)`}`);
  process.exit(77);
}
const versions = JSON.parse(fs.readFileSync(path.join(here, 'package.json'))).dependencies;
const { outputFiles } = await createRequire(path.join(out, 'package.json'))('esbuild').build({
  entryPoints: Object.keys(viewers).map(name => path.join(here, 'viewers', `${name}.mjs`)), bundle: true, format: 'esm',
  write: false, outdir: '/', logLevel: 'error', nodePaths: [path.join(out, 'node_modules')],
});
const bundles = Object.fromEntries(outputFiles.map(file => [`/${path.basename(file.path)}`, file.contents]));

// The server that pages come from, and send canvases to.
const types = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json' };
const awaited = new Map();  // functions that take what is drawn, by the clause
const server = http.createServer(async (request, response) => {
  const { pathname } = new URL(request.url, 'http://localhost');
  if (request.method === 'POST') {
    const parts = [], [, kind, clause] = pathname.split('/');
    for await (const part of request) parts.push(part);
    response.end();
    const sent = Buffer.concat(parts);
    return awaited.get(clause)?.(kind === 'pixels' ? { pixels: sent } : { error: sent.toString() });
  }
  const file = pathname === '/page.html' ? path.join(here, 'page.html') : path.join(set, pathname.replace('/set', ''));
  const body = bundles[pathname] ?? (fs.existsSync(file) ? fs.readFileSync(file) : null);
  response.writeHead(body ? 200 : 404, { 'content-type': types[path.extname(pathname)] ?? 'application/octet-stream',
    'cross-origin-opener-policy': 'same-origin', 'cross-origin-embedder-policy': 'require-corp' });
  response.end(body);
}).listen(0);

// {pixels} of one clause from the top, or {error}: a browser of its own draws it.
async function draw(viewer, clause) {
  const [name, settings = ''] = viewer.split('@'), profile = fs.mkdtempSync(path.join(os.tmpdir(), 'conformance-'));
  const query = new URLSearchParams({ viewer: name, settings, clause: JSON.stringify(clause) });
  const browser = spawn(chromium, ['--headless', '--no-sandbox', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--force-color-profile=srgb',
    '--force-device-scale-factor=1', `--user-data-dir=${profile}`,
    `http://localhost:${server.address().port}/page.html?${query}`], { stdio: 'ignore', detached: true });
  const gone = new Promise(done => browser.once('exit', done));
  const drawn = await new Promise(done => {
    awaited.set(clause.name, done);
    setTimeout(done, 180000, { error: 'nothing was drawn in three minutes' }).unref();
  });
  process.kill(-browser.pid);
  await gone;
  fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  return drawn;
}

const python = (...words) => spawnSync(process.env.PYTHON ?? 'python3', ['-B', ...words], { stdio: 'inherit' });
const all = Object.entries(viewers).flatMap(([name, [, , hasBest]]) => hasBest ? [name, `${name}@best`] : name);
const rows = [];
for (const viewer of wanted.length ? wanted : all) {
  const folder = path.join(out, viewer), reasons = {};
  const [name, settings = 'as shipped'] = viewer.split('@'), [renderer, dependency] = viewers[name];
  fs.mkdirSync(folder, { recursive: true });
  const left = [...manifest.clauses];
  await Promise.all(os.cpus().map(async () => {
    for (let clause; (clause = left.shift());) {
      const { pixels, error } = await draw(viewer, clause), file = path.join(folder, `${clause.name}.rgba`);
      fs.rmSync(file, { force: true });
      if (pixels) fs.writeFileSync(file, pixels);
      else reasons[clause.name] = error.split('\n')[0];
    }
  }));
  console.log(`\n${renderer} ${versions[dependency]}, ${settings}`);
  python(path.join(conformance, 'judge.py'), set, folder, '--blends-in-bytes', '--json', `${folder}.json`);
  for (const row of JSON.parse(fs.readFileSync(`${folder}.json`)))
    rows.push({ renderer, renderer_version: versions[dependency], settings, ...row, reason: reasons[row.clause] });
}
server.close();
const document = { format: 'swiftgs-conformance', version: 1, set: manifest.version, preset: 'gsplat',
  command: `run.mjs OUT ${wanted.join(' ')}`.trim(), machine: {
    cpu: os.cpus()[0].model, cores: os.cpus().length, gpu: `SwiftShader, ${browserVersion}`,
    date: new Date().toISOString().slice(0, 10) }, rows };
fs.writeFileSync(path.join(out, 'rows.json'), JSON.stringify(document));
python(path.join(here, 'results.py'), path.join(out, 'rows.json'), path.join(out, 'viewers.json'));
