// Where everything is at a time: linear between frames, rotations along the great circle, deformation from the modal
// coordinates. Quaternions are w, x, y, z as in the data.

/** Frame `i` and the weight `w` of frame `i + 1` at time t; held at either end. */
export function locate(times, t) {
  const last = times.length - 1;
  if (!(t > times[0])) return { i: 0, j: 0, w: 0 };
  if (t >= times[last]) return { i: last, j: last, w: 0 };
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return { i: low, j: high, w: (t - times[low]) / (times[high] - times[low]) };
}

export function interpolate(values, at) {
  return values[at.i] + (values[at.j] - values[at.i]) * at.w;
}

export function vectorAt(values, at, out = [0, 0, 0]) {
  for (let c = 0; c < 3; ++c) {
    const a = values[at.i * 3 + c];
    out[c] = a + (values[at.j * 3 + c] - a) * at.w;
  }
  return out;
}

/** Spherical interpolation, the shorter way round; the result is normalised. */
export function rotationAt(values, at, out = [1, 0, 0, 0]) {
  let dot = 0;
  for (let c = 0; c < 4; ++c) dot += values[at.i * 4 + c] * values[at.j * 4 + c];
  const sign = dot < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, Math.abs(dot)));
  const sine = Math.sin(angle);
  const near = sine < 1e-6;
  const a = near ? 1 - at.w : Math.sin((1 - at.w) * angle) / sine;
  const b = (near ? at.w : Math.sin(at.w * angle) / sine) * sign;
  let norm = 0;
  for (let c = 0; c < 4; ++c) {
    out[c] = a * values[at.i * 4 + c] + b * values[at.j * 4 + c];
    norm += out[c] * out[c];
  }
  norm = Math.sqrt(norm) || 1;
  for (let c = 0; c < 4; ++c) out[c] /= norm;
  return out;
}

export function rotate(q, v) {
  const [w, x, y, z] = q;
  const cx = 2 * (y * v[2] - z * v[1]);
  const cy = 2 * (z * v[0] - x * v[2]);
  const cz = 2 * (x * v[1] - y * v[0]);
  return [v[0] + w * cx + y * cz - z * cy, v[1] + w * cy + z * cx - x * cz, v[2] + w * cz + x * cy - y * cx];
}

export function multiply(a, b) {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

export function bodyPose(body, at) {
  return {
    position: body.position ? vectorAt(body.position, at) : [0, 0, 0],
    rotation: body.rotation ? rotationAt(body.rotation, at) : [1, 0, 0, 0],
  };
}

/** Modal coordinates η at a time; of a mesh whose points were recorded as they are, the points' displacements. */
export function modalCoordinates(mesh, at) {
  if (mesh.nodal) {
    const n = mesh.points.length;
    return mesh.points.map((x, c) => mesh.nodal[at.i * n + c] * (1 - at.w) + mesh.nodal[at.j * n + c] * at.w - x);
  }
  const modes = mesh.modes.length;
  const eta = new Float64Array(modes);
  if (!mesh.coordinates) return eta;
  for (let k = 0; k < modes; ++k) {
    const a = mesh.coordinates[at.i * modes + k];
    eta[k] = a + (mesh.coordinates[at.j * modes + k] - a) * at.w;
  }
  return eta;
}

function addShape(out, shapes, which, factor) {
  if (factor === 0) return;
  const begin = which * out.length;
  for (let c = 0; c < out.length; ++c) out[c] += factor * shapes[begin + c];
}

/** Displacements of all mesh points in the body's axes: Σ η_k φ_k + Σ η_i η_j φ_ij. */
export function displacements(mesh, eta, out) {
  if (mesh.nodal) {
    out.set(eta);
    return out;
  }
  out.fill(0);
  for (let k = 0; k < eta.length; ++k) addShape(out, mesh.shapes, k, eta[k]);
  if (mesh.pairs) {
    const { ij, shapes } = mesh.pairs;
    for (let p = 0; p < ij.length / 2; ++p) addShape(out, shapes, p, eta[ij[2 * p]] * eta[ij[2 * p + 1]]);
  }
  return out;
}

/** The displacement of one point, as displacements(). */
export function displacementOf(mesh, eta, node) {
  if (mesh.nodal) return Array.from(eta.subarray(3 * node, 3 * node + 3));
  const u = [0, 0, 0];
  const add = (shapes, which, factor) => {
    for (let c = 0; c < 3; ++c) u[c] += factor * shapes[(which * mesh.count + node) * 3 + c];
  };
  if (mesh.shapes) eta.forEach((value, k) => add(mesh.shapes, k, value));
  if (mesh.pairs) {
    const { ij, shapes } = mesh.pairs;
    for (let p = 0; p < ij.length / 2; ++p) add(shapes, p, eta[ij[2 * p]] * eta[ij[2 * p + 1]]);
  }
  return u;
}

/** A point fixed to the body, or moving with one of its mesh points, in world axes. */
export function worldPoint(body, at, position, node, pose = bodyPose(body, at), magnification = 1) {
  let local = position;
  if (node !== null && node !== undefined && body.mesh) {
    const u = displacementOf(body.mesh, modalCoordinates(body.mesh, at), node);
    local = position.map((value, c) => value + magnification * u[c]);
  }
  return rotate(pose.rotation, local).map((value, c) => value + pose.position[c]);
}

/** A marker's place and axes; a marker on several mesh points moves with their weighted mean. */
export function markerPose(run, marker, at, pose, magnification = 1) {
  const body = run.bodies[marker.body];
  const own = pose ?? bodyPose(body, at);
  let { position, node } = marker;
  if (marker.nodes?.length && marker.weights && body.mesh) {
    const eta = modalCoordinates(body.mesh, at);
    position = [...position];
    marker.nodes.forEach((one, i) => {
      const u = displacementOf(body.mesh, eta, one);
      for (let c = 0; c < 3; ++c) position[c] += magnification * marker.weights[i] * u[c];
    });
    node = null;
  }
  return {
    position: worldPoint(body, at, position, node, own, magnification),
    rotation: multiply(own.rotation, marker.rotation),
  };
}

/** The mesh point in body axes, undeformed. */
export function restPoint(mesh, node) {
  return [mesh.points[node * 3], mesh.points[node * 3 + 1], mesh.points[node * 3 + 2]];
}
