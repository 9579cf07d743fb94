// Scene model -> three.js geometry, built once a scene. In each object's own frame.
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  CylinderGeometry,
  PlaneGeometry,
  Quaternion,
  SphereGeometry,
  Vector3,
} from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';

import { subvolume_face, zero_surface } from './field_surface';
import type { ShapeModel } from './scene_image';

// A plane has no end; this much of it is shown, about what an arm reaches.
export const kPlaneSize_m = 0.4;
// The field of view into a needle's way.
export const kNeedleBlock_m = 0.06;
const kTissueCells = 96;

export interface Part {
  geometry: BufferGeometry;
  two_sided: boolean;
  faceted: boolean; // the graphics makes the normals of its triangles
  see_through: boolean;
  shade: number; // 0 to 1: how far towards the dark end of the object's colour
  grid: boolean; // a grid drawn on it gives a large plane a scale
}

const part = (geometry: BufferGeometry, more: Partial<Part> = {}): Part => ({
  geometry,
  two_sided: false,
  faceted: false,
  see_through: false,
  shade: 0,
  grid: false,
  ...more,
});

export function build_parts(shape: ShapeModel): Part[] {
  switch (shape.kind) {
    case 'plane': {
      const normal = new Vector3(...shape.normal);
      const geometry = new PlaneGeometry(kPlaneSize_m, kPlaneSize_m);
      geometry.applyQuaternion(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
      geometry.translate(normal.x * shape.offset_m, normal.y * shape.offset_m, normal.z * shape.offset_m);
      return [part(geometry, { grid: true })];
    }
    case 'sphere':
      return [part(new SphereGeometry(shape.radius_m, 48, 32))];
    case 'box': {
      const [x, y, z] = shape.half_size_m;
      return [part(new BoxGeometry(2 * x, 2 * y, 2 * z))];
    }
    // three.js stands them along y.
    case 'cylinder':
      return [part(new CylinderGeometry(shape.radius_m, shape.radius_m, 2 * shape.half_height_m, 64).rotateX(Math.PI / 2))];
    case 'capsule':
      return [part(new CapsuleGeometry(shape.radius_m, 2 * shape.half_height_m, 16, 48).rotateX(Math.PI / 2))];
    case 'mesh': {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(shape.positions, 3));
      geometry.setIndex(new BufferAttribute(shape.indices, 1));
      if (shape.normals !== null) geometry.setAttribute('normal', new BufferAttribute(shape.normals, 3));
      return [part(geometry, { two_sided: shape.two_sided, faceted: shape.normals === null })];
    }
    case 'vector_field': {
      const faces: BufferGeometry[] = [];
      for (const it of shape.subvolumes) {
        if (it.radius_m > 0) faces.push(new SphereGeometry(it.radius_m, 32, 24).translate(...it.centre_m).toNonIndexed());
        else faces.push(of_triangles(subvolume_face(it, shape.lo_m, shape.hi_m)));
      }
      const whole = mergeGeometries(faces.map(bare));
      return whole ? [part(whole, { two_sided: true, see_through: true })] : [];
    }
    case 'potential_field':
      return [part(of_triangles(zero_surface(shape)), { see_through: true, two_sided: true })];
    case 'needle': {
      const parts: Part[] = [];
      let top = 0;
      const stiffest = Math.max(...shape.layers.map((layer) => layer.stiffness_N_m), 1);
      for (const layer of shape.layers) {
        const slab = new BoxGeometry(kNeedleBlock_m, kNeedleBlock_m, layer.thickness_m).translate(0, 0, top - layer.thickness_m / 2);
        parts.push(part(slab, { see_through: true, shade: layer.stiffness_N_m / stiffest }));
        top -= layer.thickness_m;
      }
      return parts;
    }
    case 'tissue':
      return [part(new PlaneGeometry(2 * shape.half_x_m, 2 * shape.half_y_m, kTissueCells, kTissueCells), { two_sided: true })];
  }
}

function of_triangles(positions: Float32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.computeVertexNormals();
  return geometry;
}

// Only what every face has may be merged.
function bare(geometry: BufferGeometry): BufferGeometry {
  geometry.deleteAttribute('uv');
  return geometry;
}
