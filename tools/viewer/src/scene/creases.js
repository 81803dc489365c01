// Edges of a surface of triangles, where it turns or ends.

/** For every point the first one at the same place. */
export function welded(points) {
  const n = points.length / 3;
  const bits = new Uint32Array(Float32Array.from(points, (value) => value + 0).buffer); // -0 is 0
  const mask = 2 ** Math.ceil(Math.log2(2 * n + 2)) - 1;
  const slots = new Int32Array(mask + 1).fill(-1);
  const first = new Uint32Array(n);
  for (let i = 0; i < n; ++i) {
    const [a, b, c] = [bits[3 * i], bits[3 * i + 1], bits[3 * i + 2]];
    let slot = (Math.imul(a, 0x9e3779b1) ^ Math.imul(b, 0x85ebca6b) ^ Math.imul(c, 0xc2b2ae35)) >>> 0;
    slot = (slot ^ (slot >>> 15)) & mask;
    for (; slots[slot] >= 0; slot = (slot + 1) & mask) {
      const j = slots[slot];
      if (bits[3 * j] === a && bits[3 * j + 1] === b && bits[3 * j + 2] === c) break;
    }
    if (slots[slot] < 0) slots[slot] = i;
    first[i] = slots[slot];
  }
  return first;
}

/** Pairs of points: edges where the surface turns by more than `degrees`, or ends. `ids`: points that are one have one number. */
export function creaseEdges(points, triangles, degrees, ids = null) {
  const cosine = Math.cos((degrees * Math.PI) / 180);
  const count = triangles.length / 3;
  const normals = new Float32Array(triangles.length);
  const mask = 2 ** Math.ceil(Math.log2(3 * triangles.length + 2)) - 1;
  const slots = new Int32Array(mask + 1).fill(-1); // corner at which the edge begins in its first triangle; -2 - corner once met again
  const id = (corner) => (ids ? ids[triangles[corner]] : triangles[corner]);
  const next = (corner) => (corner % 3 === 2 ? corner - 2 : corner + 1);
  const sharp = [];
  for (let t = 0; t < count; ++t) {
    const [a, b, c] = [3 * triangles[3 * t], 3 * triangles[3 * t + 1], 3 * triangles[3 * t + 2]];
    const [ux, uy, uz] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
    const [vx, vy, vz] = [points[c] - points[a], points[c + 1] - points[a + 1], points[c + 2] - points[a + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], 3 * t);
    for (let corner = 3 * t; corner < 3 * t + 3; ++corner) {
      const [i, j] = [id(corner), id(next(corner))];
      const [low, high] = i < j ? [i, j] : [j, i];
      let slot = (Math.imul(low, 0x9e3779b1) ^ Math.imul(high, 0x85ebca6b)) >>> 0;
      slot = (slot ^ (slot >>> 15)) & mask;
      for (; slots[slot] !== -1; slot = (slot + 1) & mask) {
        const other = slots[slot] >= 0 ? slots[slot] : -2 - slots[slot];
        const [p, q] = [id(other), id(next(other))];
        if ((p === i && q === j) || (p === j && q === i)) break;
      }
      if (slots[slot] === -1) {
        slots[slot] = corner;
      } else if (slots[slot] >= 0) {
        const o = slots[slot] - (slots[slot] % 3);
        const n = 3 * t;
        if (normals[o] * normals[n] + normals[o + 1] * normals[n + 1] + normals[o + 2] * normals[n + 2] < cosine) sharp.push(triangles[corner], triangles[next(corner)]);
        slots[slot] = -2 - slots[slot];
      }
    }
  }
  for (const corner of slots) if (corner >= 0) sharp.push(triangles[corner], triangles[next(corner)]);
  return sharp;
}
