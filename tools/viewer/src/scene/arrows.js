// Many arrows of one kind in two instanced meshes; a moment's arrow has two heads.
import { ConeGeometry, CylinderGeometry, InstancedBufferAttribute, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, Vector3 } from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';

const kShaft = new CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0);
const kHead = new ConeGeometry(1, 1, 14).translate(0, -0.5, 0);
const kTwoHeads = mergeGeometries([kHead, kHead.clone().translate(0, -0.75, 0)]);
const kUp = new Vector3(0, 1, 0);

const direction = new Vector3();
const place = new Vector3();
const size = new Vector3();
const turn = new Quaternion();
const matrix = new Matrix4();

export class Arrows {
  constructor(capacity, two_heads, dim) {
    this.material = new MeshBasicMaterial({ transparent: dim, opacity: dim ? 0.6 : 1 });
    this.shafts = new InstancedMesh(kShaft, this.material, capacity);
    this.heads = new InstancedMesh(two_heads ? kTwoHeads : kHead, this.material, capacity);
    this.meshes = [this.shafts, this.heads];
    for (const mesh of this.meshes) {
      mesh.frustumCulled = false;
      mesh.raycast = () => {}; // not picked
    }
    this.begin();
  }

  /** Room for that many; those that are drawn are drawn anew. */
  reserve(capacity) {
    for (const mesh of this.meshes) {
      if (capacity <= mesh.instanceMatrix.count) continue;
      mesh.dispose();
      mesh.instanceMatrix = new InstancedBufferAttribute(new Float32Array(16 * 2 * capacity), 16);
      mesh.count = 0;
    }
  }

  begin() {
    this.count = 0;
  }

  /** An arrow of `length` from `point` along `vector`, `width` thick; what is shorter than its width is left out. */
  add(point, vector, length, width) {
    if (!(length > width) || this.count >= this.shafts.instanceMatrix.count) return;
    direction.fromArray(vector).normalize();
    turn.setFromUnitVectors(kUp, direction);
    const head = Math.min(4.5 * width, 0.6 * length);
    matrix.compose(place.fromArray(point), turn, size.set(0.5 * width, length - 0.9 * head, 0.5 * width));
    this.shafts.setMatrixAt(this.count, matrix);
    place.addScaledVector(direction, length);
    matrix.compose(place, turn, size.set(0.36 * head, head, 0.36 * head));
    this.heads.setMatrixAt(this.count, matrix);
    ++this.count;
  }

  end() {
    for (const mesh of this.meshes) {
      mesh.count = this.count;
      mesh.visible = this.count > 0;
      mesh.instanceMatrix.needsUpdate = true;
    }
  }
}
