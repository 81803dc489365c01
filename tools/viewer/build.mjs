// Bundles src/ into one page: node build.mjs OUT.html. Called by build.sh, which sees to the packages.
import { readFileSync, writeFileSync, mkdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];

async function bundle(entry) {
  const result = await build({
    absWorkingDir: here,
    entryPoints: [entry],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: ['es2022'],
    legalComments: 'none', // the licences stand in full at the head of the page
    logLevel: 'warning',
    charset: 'utf8',
    plugins: [shaders],
  });
  return result.outputFiles[0].text.trim();
}

// The shaders' indentation is one part in forty of the page: strings of three.js lose it. GLSL needs none.
const shaders = {
  name: 'shaders',
  setup(building) {
    building.onLoad({ filter: /three\.module\.js$/ }, ({ path }) => ({
      contents: readFileSync(path, 'utf8').replace(/(\\n)(\\t)+/g, '$1').replace(/(\\n){2,}/g, '\\n'),
    }));
  },
};

const licence = (name) => readFileSync(join(here, 'node_modules', name, 'LICENSE'), 'utf8').trim();
const licences = `<!--
This page contains three.js and uPlot.

three.js: ${licence('three')}

uPlot: ${licence('uplot')}
-->`;

const parts = {
  '<!--LICENCES-->': licences,
  '<!--STYLE-->': `<style>${await bundle('src/style.css')}</style>`,
  '<!--SCRIPT-->': `<script>${await bundle('src/main.js')}</script>`,
};
let page = readFileSync(join(here, 'src/page.html'), 'utf8');
for (const [mark, text] of Object.entries(parts)) page = page.replace(mark, () => text);
if (page.split('<!--LITHE-DATA-->').length !== 2) throw new Error('the page must have its data mark exactly once');
mkdirSync(dirname(out), { recursive: true });
writeFileSync(out, page);
console.log(`${out}: ${(page.length / 1000).toFixed(0)} kB`);
