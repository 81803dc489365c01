// Shapes that are alike, of all bodies of a run, drawn together: ten thousand bodies are a few draw calls and one array
// of matrices a geometry, written without an object a body.
import { Color, InstancedBufferAttribute, InstancedMesh, LineSegments } from 'three';

/** Lines of many instances: three.js draws what has these members with their matrices. */
class InstancedLines extends LineSegments {
  constructor(geometry, material, matrices) {
    super(geometry, material);
    Object.assign(this, { isInstancedMesh: true, instanceMatrix: matrices, instanceColor: null, morphTexture: null, count: matrices.count });
    this.frustumCulled = false;
  }

  raycast() {} // surfaces are picked
}

const colour = new Color();

export class Instances {
  /** `members`: {body (in the run), index (in the model), position, rotation} a shape; `surface`: its material, or null for lines alone. */
  constructor(geometry, members, surface, edges) {
    this.members = members;
    this.bodies = Uint32Array.from(members, ({ body }) => body);
    this.place = Float64Array.from(members.flatMap(({ position, rotation }) => [...position, ...rotation]));
    this.matrices = new InstancedBufferAttribute(new Float32Array(16 * members.length), 16);
    this.surface = surface && new InstancedMesh(geometry.surface, surface, 0);
    this.edges = geometry.edges && new InstancedLines(geometry.edges, edges, this.matrices);
    this.parts = [this.surface, this.edges].filter(Boolean);
    if (!this.surface) return;
    Object.assign(this.surface, { instanceMatrix: this.matrices, count: members.length, frustumCulled: false });
    this.surface.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * members.length), 3);
    this.surface.userData.owners = members.map(({ index }) => ({ kind: 'body', index }));
  }

  /** Colours by `of(body of the run)`; light that a selected one gives by itself is added. */
  dress(of) {
    if (!this.surface) return;
    this.members.forEach(({ body }, i) => this.surface.setColorAt(i, colour.copy(of(body))));
    this.surface.instanceColor.needsUpdate = true;
  }

  /** Matrices of the shapes from x, y, z, w, x, y, z of every body. */
  update(poses) {
    const { array } = this.matrices;
    const { bodies, place } = this;
    for (let i = 0; i < bodies.length; ++i) {
      const b = 7 * bodies[i];
      const s = 7 * i;
      const [w, x, y, z] = [poses[b + 3], poses[b + 4], poses[b + 5], poses[b + 6]];
      const [sx, sy, sz] = [place[s], place[s + 1], place[s + 2]];
      const [sw, si, sj, sk] = [place[s + 3], place[s + 4], place[s + 5], place[s + 6]];
      const cx = 2 * (y * sz - z * sy);
      const cy = 2 * (z * sx - x * sz);
      const cz = 2 * (x * sy - y * sx);
      const rw = w * sw - x * si - y * sj - z * sk;
      const ri = w * si + x * sw + y * sk - z * sj;
      const rj = w * sj - x * sk + y * sw + z * si;
      const rk = w * sk + x * sj - y * si + z * sw;
      const m = 16 * i;
      array[m] = 1 - 2 * (rj * rj + rk * rk);
      array[m + 1] = 2 * (ri * rj + rw * rk);
      array[m + 2] = 2 * (ri * rk - rw * rj);
      array[m + 4] = 2 * (ri * rj - rw * rk);
      array[m + 5] = 1 - 2 * (ri * ri + rk * rk);
      array[m + 6] = 2 * (rj * rk + rw * ri);
      array[m + 8] = 2 * (ri * rk + rw * rj);
      array[m + 9] = 2 * (rj * rk - rw * ri);
      array[m + 10] = 1 - 2 * (ri * ri + rj * rj);
      array[m + 12] = poses[b] + sx + w * cx + y * cz - z * cy;
      array[m + 13] = poses[b + 1] + sy + w * cy + z * cx - x * cz;
      array[m + 14] = poses[b + 2] + sz + w * cz + x * cy - y * cx;
      array[m + 15] = 1;
    }
    this.matrices.needsUpdate = true;
    if (this.surface) this.surface.boundingSphere = null; // for picking, which asks for it anew
  }
}
