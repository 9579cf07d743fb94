// The visible part of an infinite plane: a square about the middle, cut by the other planes; of a wall only the height of
// the scene. Pure geometry; places are in the plane's object's own frame.
import { clip } from './field_surface';
import type { HalfSpaceModel, ObjectModel } from './scene_image';
import { type Vec3, add, conjugate, cross, dot, length, rotate, scale, sub, unit } from './vector';

const kHalfSize_m = 0.3; // more than an arm reaches
const kTolerance_m = 1e-6;
const kGrid_m = 0.02;
// Of a line: some graphics drop one that begins behind the camera.
const kLongest_m = 0.05;
const kLift_m = 0.0002; // of the grid over its plane

export interface Patch {
  corners: Vec3[]; // counter-clockwise about the normal; none where nothing is left
  lines: [Vec3, Vec3][]; // a grid
}

// The plane of an object, in the world.
function in_world(object: ObjectModel): HalfSpaceModel | null {
  if (object.shape.kind !== 'plane') return null;
  const normal = rotate(object.rotation, object.shape.normal);
  return { normal, offset_m: object.shape.offset_m + dot(normal, object.position_m) };
}

// walls: from where to where in the world's height walls are shown.
export function plane_patch(objects: readonly ObjectModel[], index: number, walls: { from_m: number; to_m: number }): Patch {
  const own = in_world(objects[index]);
  if (own === null) return { corners: [], lines: [] };
  const { normal } = own;
  const u = unit(cross(Math.abs(normal[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1], normal));
  const v = cross(normal, u);
  const middle = scale(normal, own.offset_m);
  let corners: Vec3[] = [
    [1, 1],
    [-1, 1],
    [-1, -1],
    [1, -1],
  ].map(([a, b]) => add(middle, add(scale(u, a * kHalfSize_m), scale(v, b * kHalfSize_m))));
  // The part behind another plane is inside of that one.
  const sides = objects.flatMap((it, i) => {
    const other = i === index ? null : in_world(it);
    return other === null || Math.abs(dot(other.normal, normal)) > 0.99 ? [] : [turned(other)];
  });
  if (is_wall(normal)) sides.push({ normal: [0, 0, 1], offset_m: walls.to_m }, { normal: [0, 0, -1], offset_m: -walls.from_m });
  for (const side of sides) corners = clip(corners, side, kTolerance_m);
  if (corners.length < 3) return { corners: [], lines: [] };
  const lines = [...grid(corners, u, v), ...grid(corners, v, u)];
  const lift = scale(normal, kLift_m);
  const back = conjugate(objects[index].rotation);
  const local = (p: Vec3): Vec3 => rotate(back, sub(p, objects[index].position_m));
  return { corners: corners.map(local), lines: lines.map(([a, b]) => [local(add(a, lift)), local(add(b, lift))]) };
}

export const is_wall = (normal: Vec3): boolean => Math.abs(normal[2]) < 0.7;

const turned = ({ normal, offset_m }: HalfSpaceModel): HalfSpaceModel => ({ normal: scale(normal, -1), offset_m: -offset_m });

// Lines along `along`, a step apart in the direction `across`, as far as they are in a convex polygon.
function grid(corners: Vec3[], along: Vec3, across: Vec3): [Vec3, Vec3][] {
  const lines: [Vec3, Vec3][] = [];
  const at = corners.map((corner) => dot(corner, across));
  for (let i = Math.ceil(Math.min(...at) / kGrid_m); i * kGrid_m < Math.max(...at); ++i) {
    const crossings = corners.flatMap((b, j) => {
      const before = (j + corners.length - 1) % corners.length;
      const [from, to] = [at[before] - i * kGrid_m, at[j] - i * kGrid_m];
      return from > 0 === to > 0 ? [] : [add(corners[before], scale(sub(b, corners[before]), from / (from - to)))];
    });
    if (crossings.length === 2) lines.push(...pieces(crossings[0], crossings[1]));
  }
  return lines;
}

function pieces(from: Vec3, to: Vec3): [Vec3, Vec3][] {
  const way = sub(to, from);
  const count = Math.ceil(length(way) / kLongest_m);
  const at = (i: number): Vec3 => add(from, scale(way, i / count));
  return Array.from({ length: count }, (_, i) => [at(i), at(i + 1)]);
}
