// The page of a run that goes on, or has just ended, as a file that needs no program any more.

async function packed(chunks) {
  const stream = new Blob(chunks).stream().pipeThrough(new CompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** The page's JSON with refs into a new buffer, and that buffer in chunks; `arrays`: by the refs of now. */
function repacked(json, arrays) {
  const chunks = [];
  let size = 0;
  const copy = (one) => {
    if (Array.isArray(one)) return one.map(copy);
    if (!one || typeof one !== 'object') return one;
    const array = arrays.get(one);
    if (!array) return Object.fromEntries(Object.entries(one).map(([key, value]) => [key, copy(value)]));
    const at = size;
    const padding = (8 - (array.byteLength % 8)) % 8;
    chunks.push(array, new Uint8Array(padding));
    size += array.byteLength + padding;
    return { at, n: array.length, type: one.type };
  };
  return { scene: copy(json), chunks };
}

export async function savedPage(page, growing) {
  const arrays = new Map([...page.refs].map(([array, ref]) => [ref, array]));
  for (const [ref, array] of growing.grown()) arrays.set(ref, array);
  const { live, ...json } = page.json;
  const { scene, chunks } = repacked(json, arrays);
  const root = document.documentElement.cloneNode(true);
  root.removeAttribute('data-theme');
  const app = root.querySelector('#app');
  app.className = '';
  app.replaceChildren();
  root.querySelector('#lithe-scene').textContent = JSON.stringify(scene).replaceAll('<', '\\u003c');
  root.querySelector('#lithe-data').textContent = await packed(chunks);
  return `<!doctype html>\n${root.outerHTML}\n`;
}
