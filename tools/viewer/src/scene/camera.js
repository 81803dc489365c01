// The eye: orbit, views along the axes, fit, following a body; in perspective or parallel.
import { OrthographicCamera, PerspectiveCamera, Quaternion, Spherical, Vector3 } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const kFieldOfView = 32; // degrees, from top to bottom

export class Eye {
  constructor(canvas, up, changed) {
    this.perspective = new PerspectiveCamera(kFieldOfView, 1, 0.01, 1000);
    this.parallel = new OrthographicCamera(-1, 1, 1, -1, 0.01, 1000);
    for (const camera of [this.perspective, this.parallel]) camera.up.copy(up);
    this.up = up;
    this.camera = this.perspective;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', changed);
    this.controls.zoomToCursor = true;
    this.by_hand = false; // moved by whoever looks
    this.controls.addEventListener('start', () => { this.by_hand = true; });
    this.aspect = 1;
    this.extent = 1;
    this.followed = null;
  }

  get target() {
    return this.controls.target;
  }

  resize(aspect) {
    this.aspect = aspect;
    this.perspective.aspect = aspect;
    this.perspective.updateProjectionMatrix();
    this.#frameParallel();
  }

  /** The parallel camera shows what the perspective one shows in the plane of the target. */
  #frameParallel() {
    const distance = this.camera.position.distanceTo(this.target);
    const half = this.parallel_half ?? distance * Math.tan((kFieldOfView * Math.PI) / 360);
    Object.assign(this.parallel, { left: -half * this.aspect, right: half * this.aspect, top: half, bottom: -half });
    this.parallel.updateProjectionMatrix();
  }

  setParallel(parallel) {
    const camera = parallel ? this.parallel : this.perspective;
    if (camera === this.camera) return;
    camera.position.copy(this.camera.position);
    if (parallel) {
      this.parallel.zoom = 1;
      this.parallel_half = this.camera.position.distanceTo(this.target) * Math.tan((kFieldOfView * Math.PI) / 360);
    }
    this.camera = camera;
    this.controls.object = camera;
    this.#frameParallel();
    this.controls.update();
  }

  /** Looks from `direction` (towards the eye; null keeps the present one) so that all points are in the picture. */
  fit(points, direction = null) {
    if (!points.length) points = [[-1, -1, -1], [1, 1, 1]];
    const back = direction ? new Vector3(...direction).normalize() : this.camera.position.clone().sub(this.target).normalize();
    if (back.lengthSq() < 0.5) back.set(1, -1, 0.6).normalize();
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = low.clone().negate();
    const all = points.map((point) => new Vector3(...point));
    for (const point of all) {
      low.min(point);
      high.max(point);
    }
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const up = Math.abs(back.dot(this.up)) > 0.999 ? new Vector3(this.up.y, this.up.z, this.up.x) : this.up;
    const right = up.clone().cross(back).normalize();
    const above = back.clone().cross(right);
    const vertical = Math.tan((kFieldOfView * Math.PI) / 360) / 1.16;
    const horizontal = vertical * this.aspect;
    let distance = 1e-6;
    let half = 1e-6;
    for (const point of all) {
      point.sub(centre);
      const x = Math.abs(point.dot(right));
      const y = Math.abs(point.dot(above));
      distance = Math.max(distance, point.dot(back) + x / horizontal, point.dot(back) + y / vertical);
      half = Math.max(half, (1.16 * x) / this.aspect, 1.16 * y);
    }
    this.extent = high.distanceTo(low) || 1;
    this.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(back, Math.max(distance, 1e-3 * this.extent));
    this.parallel_half = half;
    this.parallel.zoom = 1;
    for (const camera of [this.perspective, this.parallel]) {
      camera.near = Math.max(1e-4 * this.extent, 1e-3 * distance);
      camera.far = 60 * Math.max(distance, this.extent);
      camera.updateProjectionMatrix();
    }
    this.#frameParallel();
    this.controls.update();
  }

  /** Around the target by radians, to the side about the vertical and upwards. */
  turn(side, up) {
    const upright = new Quaternion().setFromUnitVectors(this.up, new Vector3(0, 1, 0));
    const around = new Spherical().setFromVector3(this.camera.position.clone().sub(this.target).applyQuaternion(upright));
    around.theta += side;
    around.phi -= up;
    this.camera.position.setFromSpherical(around.makeSafe()).applyQuaternion(upright.invert()).add(this.target);
    this.#moved();
  }

  /** Things get `factor` times as large, about the target. */
  zoom(factor) {
    if (this.camera === this.parallel) {
      this.parallel.zoom *= factor;
      this.parallel.updateProjectionMatrix();
    } else {
      this.camera.position.sub(this.target).divideScalar(factor).add(this.target);
    }
    this.#moved();
  }

  /** To the right and up by parts of what the picture shows from top to bottom. */
  slide(right, up) {
    const height = this.camera === this.parallel ? (this.parallel.top - this.parallel.bottom) / this.parallel.zoom
      : 2 * Math.tan((kFieldOfView * Math.PI) / 360) * this.camera.position.distanceTo(this.target);
    const step = new Vector3(right * height, up * height, 0).applyQuaternion(this.camera.quaternion);
    this.target.add(step);
    this.camera.position.add(step);
    this.#moved();
  }

  #moved() {
    this.by_hand = true;
    this.controls.update();
  }

  /** Moves along with a point; null lets go. */
  follow(point) {
    if (point && this.followed) {
      const step = new Vector3(...point).sub(this.followed);
      this.target.add(step);
      this.camera.position.add(step);
      this.controls.update();
    }
    this.followed = point ? new Vector3(...point) : null;
  }
}
