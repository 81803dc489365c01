// Reads the two data elements of the page into runs with typed arrays. The format is told in tools/viewer/README.md.

/** What is wrong with the data, and how to fix it: shown in the page in place of the run. */
export class PageError extends Error {
  constructor(what, fix) {
    super(what);
    this.fix = fix;
  }
}

const kTypes = {
  f64: Float64Array,
  f32: Float32Array,
  u32: Uint32Array,
  u16: Uint16Array,
  i16: Int16Array,
  u8: Uint8Array,
};
const kWriteAgain = 'write the page again with write_page() or lithe view, and copy the file as binary.';

/** The inflated bytes, handed out as typed arrays. */
class Arrays {
  constructor(bytes) {
    this.bytes = bytes;
    this.refs = new Map(); // of the arrays handed out
  }

  /** The array that `ref` names; `count` is how many numbers it must have; `what` says whose it is. */
  read(ref, what, count) {
    const Type = kTypes[ref?.type];
    if (!Type) throw new PageError(`${what} has the unknown number type '${ref?.type}'.`, kWriteAgain);
    const end = ref.at + ref.n * Type.BYTES_PER_ELEMENT;
    if (!(ref.at >= 0) || !(ref.n >= 0) || ref.at % 8 !== 0 || end > this.bytes.byteLength) {
      throw new PageError(`${what} reaches past the end of the data (byte ${end} of ${this.bytes.byteLength}).`,
        kWriteAgain);
    }
    if (count !== undefined && ref.n !== count) {
      throw new PageError(`${what} has ${ref.n} numbers where ${count} are needed.`, kWriteAgain);
    }
    const stored = new Type(this.bytes.buffer, this.bytes.byteOffset + ref.at, ref.n);
    this.refs.set(stored, ref);
    if (ref.scale === undefined || ref.scale === null) return stored;
    const rows = ref.n / ref.scale.length;
    return Float32Array.from(stored, (value, i) => value * ref.scale[Math.floor(i / rows)]);
  }

  /** As read(), or null where the run has none. */
  maybe(ref, what, count) {
    return ref ? this.read(ref, what, count) : null;
  }
}

function bytesOfBase64(text) {
  const clean = text.trim();
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(clean);
  const binary = atob(clean);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function readMesh(json, arrays, what, frames) {
  const points = arrays.read(json.points, `${what}: points`);
  const n = points.length / 3;
  const mode_count = json.modes?.length ?? 0;
  const mesh = {
    points,
    count: n,
    triangles: arrays.read(json.triangles, `${what}: triangles`),
    edges: arrays.maybe(json.edges, `${what}: edges`),
    modes: json.modes ?? [],
    natural: json.natural !== false,
    coordinates: arrays.maybe(json.coordinates, `${what}: modal coordinates`, frames * mode_count),
    shapes: arrays.maybe(json.shapes, `${what}: mode shapes`, mode_count * n * 3),
    nodal: arrays.maybe(json.nodal, `${what}: points of the frames`, frames * n * 3),
    pairs: null,
    stress: null,
    fields: (json.fields ?? []).map(({ name, unit, values }) => ({ name, unit: unit ?? '', values: arrays.read(values, `${what}: ${name}`, n) })),
  };
  if (json.pairs) {
    const ij = arrays.read(json.pairs.ij, `${what}: pairs of modes`);
    mesh.pairs = { ij, shapes: arrays.read(json.pairs.shapes, `${what}: shapes of pairs`, (ij.length / 2) * n * 3) };
  }
  if (json.stress) {
    mesh.stress = {
      unit: json.stress.unit ?? 'Pa',
      shapes: arrays.read(json.stress.shapes, `${what}: stress shapes`, mode_count * n * 6),
      static: arrays.maybe(json.stress.static, `${what}: static stress`, n * 6),
    };
  }
  for (const index of mesh.triangles) {
    if (index >= n) throw new PageError(`${what}: a triangle names point ${index} of ${n}.`, kWriteAgain);
  }
  return mesh;
}

function readBody(json, index, arrays, where, frames) {
  const what = `${where}, body '${json.name}'`;
  const shapes = (json.shapes ?? []).map((shape) => ({
    ...shape,
    size: shape.size ?? [],
    position: shape.position ?? [0, 0, 0],
    rotation: shape.rotation ?? [1, 0, 0, 0],
    points: arrays.maybe(shape.points, `${what}, shape: points`),
    triangles: arrays.maybe(shape.triangles, `${what}, shape: triangles`),
  }));
  return {
    index,
    name: json.name,
    kind: json.kind ?? 'Body',
    where: json.where ?? '',
    frame: json.frame === true,
    position: arrays.maybe(json.position, `${what}: position`, frames * 3),
    rotation: arrays.maybe(json.rotation, `${what}: rotation`, frames * 4),
    shapes,
    mesh: json.mesh ? readMesh(json.mesh, arrays, `${what}, mesh`, frames) : null,
  };
}

function readConnector(json, index, arrays, where, frames) {
  const what = `${where}, connector '${json.name}'`;
  const reaction = json.reaction && {
    point: arrays.maybe(json.reaction.point, `${what}: point of reaction`, frames * 3),
    force: arrays.maybe(json.reaction.force, `${what}: reaction force`, frames * 3),
    moment: arrays.maybe(json.reaction.moment, `${what}: reaction moment`, frames * 3),
  };
  const line = arrays.maybe(json.line, `${what}: line`);
  if (line && (line.length === 0 || line.length % (3 * frames) !== 0)) {
    throw new PageError(`${what}: line has ${line.length} numbers for ${frames} frames.`, kWriteAgain);
  }
  return {
    index,
    name: json.name,
    kind: json.kind ?? 'Connector',
    role: json.role ?? 'joint',
    bodies: json.bodies ?? [],
    markers: json.markers ?? [],
    where: json.where ?? '',
    reaction: reaction ?? null,
    line, // of a rope: frames x points x 3
  };
}

function readContacts(json, arrays, where, frames) {
  if (!json) return null;
  const first = arrays.read(json.first, `${where}: contacts of a frame`, frames + 1);
  const total = first[frames];
  return {
    first,
    points: arrays.read(json.points, `${where}: contact points`, total * 3),
    forces: arrays.read(json.forces, `${where}: contact forces`, total * 3),
    pair: arrays.maybe(json.pair, `${where}: pairs in contact`, total),
  };
}

function readRun(json, index, arrays) {
  const name = json.name || `run ${index + 1}`;
  const where = `run '${name}'`;
  const times = arrays.read(json.times, `${where}: times`);
  const frames = times.length;
  if (frames === 0) throw new PageError(`${where} has no frame.`, 'record at least one state before writing the page.');
  for (let i = 0; i < frames; ++i) {
    if (!Number.isFinite(times[i]) || (i > 0 && times[i] < times[i - 1])) {
      throw new PageError(`${where}: times must grow, but frame ${i} is at ${times[i]} s.`, kWriteAgain);
    }
  }
  const bodies = (json.bodies ?? []).map((body, i) => readBody(body, i, arrays, where, frames));
  const markers = (json.markers ?? []).map((marker) => ({
    name: marker.name ?? '',
    body: marker.body,
    position: marker.position ?? [0, 0, 0],
    rotation: marker.rotation ?? [1, 0, 0, 0],
    node: marker.node ?? null,
    nodes: marker.nodes ?? null, // where it is the mean of several
    weights: marker.weights ?? null,
  }));
  for (const marker of markers) {
    const body = bodies[marker.body];
    if (!body) throw new PageError(`${where}: marker '${marker.name}' is on no body of the run.`, kWriteAgain);
    if (marker.node !== null && !(marker.node < (body.mesh?.count ?? 0))) {
      throw new PageError(`${where}: marker '${marker.name}' follows a point that '${body.name}' lacks.`, kWriteAgain);
    }
  }
  return {
    index,
    name,
    gravity: json.gravity ?? [0, 0, 0],
    times,
    frames,
    bodies,
    markers,
    connectors: (json.connectors ?? []).map((one, i) => readConnector(one, i, arrays, where, frames)),
    contacts: readContacts(json.contacts, arrays, where, frames),
    traces: (json.traces ?? []).map((trace) => ({
      name: trace.name,
      points: arrays.read(trace.points, `${where}, trace '${trace.name}'`, frames * 3),
    })),
    channels: (json.channels ?? []).map((channel) => ({
      name: channel.name,
      unit: channel.unit ?? '',
      group: channel.group ?? 'recorded',
      body: channel.body ?? null,
      connector: channel.connector ?? null,
      values: arrays.read(channel.values, `${where}, channel '${channel.name}'`, frames),
    })),
    notes: json.notes ?? [],
    events: (json.events ?? []).filter((event) => Number.isFinite(event.time)),
  };
}

/** The page's title, origin and runs. Throws PageError for data that are missing, broken or of another version. */
export async function readPage(page = document) {
  const scene_element = page.getElementById('lithe-scene');
  const data_element = page.getElementById('lithe-data');
  if (!scene_element || !data_element) {
    throw new PageError('This page holds no run: it is the empty viewer.', 'open a page that write_page() wrote.');
  }
  let json;
  try {
    json = JSON.parse(scene_element.textContent);
  } catch (error) {
    throw new PageError(`The description of the scene is no JSON: ${error.message}`, kWriteAgain);
  }
  if (json.format !== 'lithe-page' || json.version !== 1) {
    throw new PageError(`The data are '${json.format}' version ${json.version}; this viewer reads 'lithe-page' version 1.`,
      'write the page with the version of Lithe that recorded the run.');
  }
  if (!json.runs?.length) throw new PageError('The page has no run.', 'hand write_page() at least one run.');
  let bytes;
  try {
    const packed = bytesOfBase64(data_element.textContent);
    bytes = packed.length > 0 ? await inflate(packed) : packed;
  } catch (error) {
    throw new PageError(`The numbers of the run cannot be unpacked (${error.message}).`, kWriteAgain);
  }
  const arrays = new Arrays(bytes);
  return {
    title: json.title || 'Lithe',
    made_by: json.made_by ?? '',
    findings: json.findings ?? [],
    runs: json.runs.map((run, i) => readRun(run, i, arrays)),
    live: json.live ?? null, // {width}: numbers of a state, of a run that goes on
    json,
    refs: arrays.refs, // array -> its ref in the JSON
  };
}
