// A finite-element body: its boundary deforms from the modal coordinates and carries a field as colours.
import {
  BufferAttribute, BufferGeometry, DataTexture, DynamicDrawUsage, LinearFilter, LineBasicMaterial, LineSegments, Mesh,
  MeshLambertMaterial, NearestFilter, DoubleSide, SRGBColorSpace,
} from 'three';
import { displacements } from '../motion.js';
import { viridis } from '../palette.js';
import { creaseEdges } from './creases.js';
import { FieldOnMesh } from './field.js';

export const kBands = 10;

/** The colour map as a row of texels, smooth or in bands. */
export function mapTexture(bands) {
  const n = bands ? kBands : 256;
  const texels = new Uint8Array(n * 4);
  for (let i = 0; i < n; ++i) texels.set([...viridis(i / (n - 1)), 255], 4 * i);
  const texture = new DataTexture(texels, n, 1);
  texture.magFilter = texture.minFilter = bands ? NearestFilter : LinearFilter;
  texture.colorSpace = SRGBColorSpace;
  texture.needsUpdate = true;
  return texture;
}

const textures = {};
const kCrease = 35; // degrees

export class MeshBody {
  constructor(mesh, colour) {
    this.mesh = mesh;
    this.colour = colour;
    this.field = new FieldOnMesh(mesh);
    this.u = new Float32Array(mesh.count * 3);
    const position = new BufferAttribute(Float32Array.from(mesh.points), 3).setUsage(DynamicDrawUsage);
    this.map_place = new BufferAttribute(new Float32Array(mesh.count * 2).fill(0.5), 2).setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', position);
    geometry.setAttribute('uv', this.map_place);
    geometry.setIndex(new BufferAttribute(Uint32Array.from(mesh.triangles), 1));
    this.material = new MeshLambertMaterial({ flatShading: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.surface = new Mesh(geometry, this.material);
    this.surface.frustumCulled = false;
    this.parts = [this.surface];
    const lines = (index, opacity) => {
      const line_geometry = new BufferGeometry();
      line_geometry.setAttribute('position', position);
      line_geometry.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
      const drawn = new LineSegments(line_geometry, new LineBasicMaterial({ transparent: true, opacity }));
      drawn.frustumCulled = false;
      drawn.raycast = () => {}; // the surface is picked
      this.parts.push(drawn);
      return drawn;
    };
    this.elements = mesh.edges ? lines(mesh.edges, 0.14) : null;
    this.creases = lines(creaseEdges(mesh.points, mesh.triangles, kCrease), 0.75);
  }

  /** Colours of surface and lines; a field keeps its true colours. */
  dress({ colour, edge, selected, accent, field, show }) {
    const painted = this.field.has(field);
    this.colour = colour;
    if (!painted) this.material.color.set(colour);
    this.material.emissive.set(selected && !painted ? accent : '#000');
    this.material.emissiveIntensity = 0.35;
    this.creases.material.color.set(selected ? accent : edge);
    this.creases.material.opacity = selected ? 1 : 0.75;
    this.creases.visible = show.edges || selected;
    if (!this.elements) return;
    this.elements.material.color.set(edge);
    this.elements.visible = show.elements;
  }

  /** Moves the points to x + magnification · u(η). */
  deform(eta, magnification) {
    displacements(this.mesh, eta, this.u);
    const { array } = this.surface.geometry.attributes.position;
    const { points } = this.mesh;
    for (let c = 0; c < array.length; ++c) array[c] = points[c] + magnification * this.u[c];
    this.surface.geometry.attributes.position.needsUpdate = true;
    this.surface.geometry.boundingSphere = null; // for picking, which asks for it anew
    this.eta = eta;
  }

  /** The field's values at the present deformation, or null where this mesh has no such field. */
  values(name) {
    return this.field.has(name) ? this.field.evaluate(name, this.eta, this.u) : null;
  }

  paint(values, range, bands) {
    const key = bands ? 'bands' : 'smooth';
    const map = values ? (textures[key] ??= mapTexture(bands)) : null;
    if (this.material.map !== map) {
      if (!this.material.map !== !map) this.material.needsUpdate = true;
      this.material.map = map;
    }
    this.material.color.set(map ? 0xffffff : this.colour);
    if (!values) return;
    // Linear filtering reads between texel centres: the ends of the range lie on the first and last centre.
    const inset = bands ? 0 : 0.5 / 256;
    const span = range[1] - range[0] || 1;
    const { array } = this.map_place;
    for (let i = 0; i < values.length; ++i) {
      const x = Math.min(0.99999, Math.max(0, (values[i] - range[0]) / span));
      array[2 * i] = inset + x * (1 - 2 * inset);
    }
    this.map_place.needsUpdate = true;
  }
}
