// Surfaces of the volumes that have none of their own: the faces that a vector field pushes with, the zero of a potential.
// Each is a list of triangles, nine numbers each, in the object's frame.
import type { HalfSpaceModel, PotentialModel, SubvolumeModel } from './scene_image';
import { type Vec3, add, cross, dot, scale, sub, unit } from './vector';

// The part of the pushing plane that is in its subvolume and in the field's box: a polygon, cut by one half space after the other.
export function subvolume_face(it: SubvolumeModel, lo_m: Vec3, hi_m: Vec3): Float32Array {
  const normal = it.plane.normal;
  const middle = scale(add(lo_m, hi_m), 0.5);
  const centre = sub(middle, scale(normal, dot(normal, middle) - it.plane.offset_m));
  const u = unit(cross(Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], normal));
  const v = cross(normal, u);
  const reach = 2 * Math.max(hi_m[0] - lo_m[0], hi_m[1] - lo_m[1], hi_m[2] - lo_m[2]);
  let polygon: Vec3[] = [
    [1, 1],
    [-1, 1],
    [-1, -1],
    [1, -1],
  ].map(([a, b]) => add(centre, add(scale(u, a * reach), scale(v, b * reach))));
  for (const side of [...it.sides, ...box_sides(lo_m, hi_m)]) polygon = clip(polygon, side, reach * 1e-5);
  const out: number[] = [];
  for (let i = 2; i < polygon.length; ++i) out.push(...polygon[0], ...polygon[i - 1], ...polygon[i]);
  return new Float32Array(out);
}

function box_sides(lo: Vec3, hi: Vec3): HalfSpaceModel[] {
  return [
    { normal: [1, 0, 0], offset_m: hi[0] },
    { normal: [0, 1, 0], offset_m: hi[1] },
    { normal: [0, 0, 1], offset_m: hi[2] },
    { normal: [-1, 0, 0], offset_m: -lo[0] },
    { normal: [0, -1, 0], offset_m: -lo[1] },
    { normal: [0, 0, -1], offset_m: -lo[2] },
  ];
}

// Clipping by Sutherland and Hodgman. Points on the side itself, within the tolerance, are kept.
export function clip(polygon: Vec3[], { normal, offset_m }: HalfSpaceModel, tolerance_m: number): Vec3[] {
  const out: Vec3[] = [];
  polygon.forEach((b, i) => {
    const a = polygon[(i + polygon.length - 1) % polygon.length];
    const over_a = dot(normal, a) - offset_m - tolerance_m;
    const over_b = dot(normal, b) - offset_m - tolerance_m;
    if (over_a > 0 !== over_b > 0) out.push(add(a, scale(sub(b, a), over_a / (over_a - over_b))));
    if (over_b <= 0) out.push(b);
  });
  return out;
}

// The spline's value at its own knots: 1/6, 4/6, 1/6 along each axis. One knot fewer at either end.
function knot_values({ count, coefficients }: PotentialModel): { size: Vec3; values: Float32Array } {
  let size = [...count];
  let values = coefficients;
  let stride = 1;
  for (let axis = 0; axis < 3; ++axis) {
    const shorter = size.map((n, i) => (i === axis ? n - 2 : n));
    const out = new Float32Array(shorter[0] * shorter[1] * shorter[2]);
    stride = axis === 0 ? 1 : axis === 1 ? size[0] : size[0] * size[1];
    let at = 0;
    for (let k = 0; k < shorter[2]; ++k)
      for (let j = 0; j < shorter[1]; ++j)
        for (let i = 0; i < shorter[0]; ++i) {
          const from = i + size[0] * (j + size[1] * k);
          out[at++] = (values[from] + 4 * values[from + stride] + values[from + 2 * stride]) / 6;
        }
    size = shorter;
    values = out;
  }
  return { size: [size[0], size[1], size[2]], values };
}

// A knot on the surface is zero but for rounding, so the surface is drawn a little inside, where u is this share of its most.
const kLevel = 0.002;

// Naive surface nets (Gibson 1998): a vertex in each cell that the zero crosses, a quadrangle about each edge that it crosses.
export function zero_surface(field: PotentialModel): Float32Array {
  if (field.count.some((n) => n < 4)) return new Float32Array();
  const { size, values } = knot_values(field);
  const [nx, ny, nz] = size;
  const level = kLevel * values.reduce((most, value) => Math.max(most, value), 0);
  for (let i = 0; i < values.length; ++i) values[i] -= level;
  const index = (i: number, j: number, k: number) => i + nx * (j + ny * k);
  const corner = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [bits & 1, (bits >> 1) & 1, bits >> 2] as Vec3);
  const vertices = new Map<number, Vec3>();
  const vertex = (i: number, j: number, k: number): Vec3 => {
    const cell = index(i, j, k);
    let found = vertices.get(cell);
    if (found !== undefined) return found;
    let sum: Vec3 = [0, 0, 0];
    let crossings = 0;
    for (let a = 0; a < 8; ++a)
      for (let axis = 0; axis < 3; ++axis) {
        if (a & (1 << axis)) continue;
        const from = corner[a];
        const to = corner[a | (1 << axis)];
        const at_from = values[index(i + from[0], j + from[1], k + from[2])];
        const at_to = values[index(i + to[0], j + to[1], k + to[2])];
        if (at_from > 0 === at_to > 0) continue;
        sum = add(sum, add(from, scale(sub(to, from), at_from / (at_from - at_to))));
        ++crossings;
      }
    // The first knot lies one step from the first coefficient.
    const inner = crossings > 0 ? scale(sum, 1 / crossings) : ([0.5, 0.5, 0.5] as Vec3);
    found = add(field.origin_m, scale([inner[0] + i + 1, inner[1] + j + 1, inner[2] + k + 1], field.step_m));
    vertices.set(cell, found);
    return found;
  };
  const out: number[] = [];
  for (let k = 1; k < nz - 1; ++k)
    for (let j = 1; j < ny - 1; ++j)
      for (let i = 1; i < nx - 1; ++i) {
        const inside = values[index(i, j, k)] > 0;
        for (let axis = 0; axis < 3; ++axis) {
          const next = [i, j, k];
          ++next[axis];
          if (values[index(next[0], next[1], next[2])] > 0 === inside) continue;
          const b = (axis + 1) % 3;
          const c = (axis + 2) % 3;
          const at = (db: number, dc: number): Vec3 => {
            const cell = [i, j, k];
            cell[b] -= db;
            cell[c] -= dc;
            return vertex(cell[0], cell[1], cell[2]);
          };
          // Counter-clockwise about the axis, so seen from the outside where u falls along it.
          const ring = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
          if (!inside) ring.reverse();
          out.push(...ring[0], ...ring[1], ...ring[2], ...ring[0], ...ring[2], ...ring[3]);
        }
      }
  return new Float32Array(out);
}
