// Scene model -> three.js geometry, built once a scene. In each object's own frame.
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  ConeGeometry,
  CylinderGeometry,
  PlaneGeometry,
  SphereGeometry,
} from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';

import { subvolume_face, zero_surface } from './field_surface';
import type { Patch } from './plane_patch';
import type { ShapeModel, StiffnessMapModel } from './scene_image';
import { type Vec3, add, cross, scale, unit } from './vector';

// The field of view into a needle's way.
export const kNeedleBlock_m = 0.06;
const kTissueCells = 96;
const kWorkspace_m = 1; // half of any arm's, and more

export interface Part {
  geometry: BufferGeometry;
  two_sided: boolean;
  faceted: boolean; // the graphics makes the normals of its triangles
  see_through: boolean;
  shade: number; // 0 to 1: how far towards the dark end of the object's colour
}

const part = (geometry: BufferGeometry, more: Partial<Part> = {}): Part => ({
  geometry,
  two_sided: false,
  faceted: false,
  see_through: false,
  shade: 0,
  ...more,
});

export function build_parts(shape: ShapeModel): Part[] {
  switch (shape.kind) {
    case 'plane':
      return []; // plane_patch.ts
    case 'sphere':
      return [part(new SphereGeometry(shape.radius_m, 48, 32))];
    case 'box': {
      const [x, y, z] = shape.half_size_m;
      return [part(in_metres(new BoxGeometry(2 * x, 2 * y, 2 * z), [x, y, z]))];
    }
    // three.js stands them along y.
    case 'cylinder':
      return [part(new CylinderGeometry(shape.radius_m, shape.radius_m, 2 * shape.half_height_m, 64).rotateX(Math.PI / 2))];
    case 'capsule':
      return [part(new CapsuleGeometry(shape.radius_m, 2 * shape.half_height_m, 16, 48).rotateX(Math.PI / 2))];
    case 'cone': // the origin is the centre of mass, a quarter of the height above the base
      return [part(new ConeGeometry(shape.radius_m, shape.height_m, 64).rotateX(Math.PI / 2).translate(0, 0, shape.height_m / 4))];
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
    case 'force_field': {
      const [x, y, z] = shape.half_size_m;
      if (Math.max(x, y, z) > kWorkspace_m) return []; // everywhere
      return [part(in_metres(new BoxGeometry(2 * x, 2 * y, 2 * z), [x, y, z]), { two_sided: true, see_through: true })];
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

// The texture coordinates of a box, which three.js has from 0 to 1 on each of its six faces.
function in_metres(box: BoxGeometry, [x, y, z]: Vec3): BoxGeometry {
  const sizes = [[z, y], [z, y], [x, z], [x, z], [x, y], [x, y]]; // prettier-ignore
  const uv = box.getAttribute('uv');
  for (let i = 0; i < uv.count; ++i) uv.setXY(i, 2 * sizes[i >> 2][0] * uv.getX(i), 2 * sizes[i >> 2][1] * uv.getY(i));
  return box;
}

// Only attributes that all parts have can be merged.
function bare(geometry: BufferGeometry): BufferGeometry {
  geometry.deleteAttribute('uv');
  return geometry;
}

// A convex polygon as a fan.
export function of_patch({ corners }: Patch): BufferGeometry {
  const fan: number[] = [];
  for (let i = 2; i < corners.length; ++i) fan.push(...corners[0], ...corners[i - 1], ...corners[i]);
  return of_triangles(new Float32Array(fan));
}

export function of_lines({ lines }: Patch): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(lines.flat(2)), 3));
  return geometry;
}

const kMapSteps = 4; // of a cell
const kMapLift_m = 0.0003; // over the surface that it lies on

// The stiffness of a flat surface in colours: `color(share)`, from 0 where it is softest to 1 where it is stiffest.
export function of_stiffness_map(map: StiffnessMapModel, color: (share: number) => readonly [number, number, number]): BufferGeometry {
  const [columns, rows] = [map.columns, map.rows].map((n) => (n - 1) * kMapSteps + 1);
  const values = new Float32Array(columns * rows);
  for (let j = 0; j < rows; ++j) for (let i = 0; i < columns; ++i) values[i + columns * j] = spline(map, i / kMapSteps, j / kMapSteps);
  const least = values.reduce((a, b) => Math.min(a, b), Infinity);
  const most = values.reduce((a, b) => Math.max(a, b), -Infinity);
  const positions = new Float32Array(values.length * 3);
  const colors = new Float32Array(values.length * 3);
  const lift = scale(unit(cross(map.u, map.v)), kMapLift_m);
  values.forEach((value, at) => {
    const along = scale(map.u, ((at % columns) / kMapSteps) * map.cell_m);
    const across = scale(map.v, (Math.floor(at / columns) / kMapSteps) * map.cell_m);
    positions.set(add(add(map.origin_m, lift), add(along, across)), at * 3);
    colors.set(color(most > least ? (value - least) / (most - least) : 0), at * 3);
  });
  const indices: number[] = [];
  for (let j = 0; j + 1 < rows; ++j)
    for (let i = 0; i + 1 < columns; ++i) {
      const at = i + columns * j;
      indices.push(at, at + 1, at + columns, at + 1, at + columns + 1, at + columns);
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('color', new BufferAttribute(colors, 3));
  geometry.setIndex(indices);
  geometry.computeVertexNormals();
  return geometry;
}

// The bicubic B-spline at (u, v), in cells from the first control point; beyond the border the value at the border holds.
export function spline(map: StiffnessMapModel, u: number, v: number): number {
  const weights = (t: number) =>
    [(1 - t) ** 3, 3 * t ** 3 - 6 * t ** 2 + 4, -3 * t ** 3 + 3 * t ** 2 + 3 * t + 1, t ** 3].map((w) => w / 6);
  const [i, j] = [Math.floor(u), Math.floor(v)];
  const along = weights(u - i);
  const inside = (n: number, most: number) => Math.min(Math.max(n, 0), most - 1);
  let sum = 0;
  weights(v - j).forEach((across, b) => {
    const row = inside(j + b - 1, map.rows) * map.columns;
    for (let a = 0; a < 4; ++a) sum += across * along[a] * map.stiffness_N_m[row + inside(i + a - 1, map.columns)];
  });
  return sum;
}
