// What is shown of planes, and of a map of stiffness.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { spline } from '../../src/geometry';
import { plane_patch } from '../../src/plane_patch';
import type { ObjectModel } from '../../src/scene_image';
import type { Quat, Vec3 } from '../../src/vector';

const plane = (normal: Vec3, offset_m: number, position_m: Vec3 = [0, 0, 0], rotation: Quat = [1, 0, 0, 0]): ObjectModel => ({
  name: '',
  shape: { kind: 'plane', normal, offset_m },
  texture: null,
  stiffness_map: null,
  position_m,
  rotation,
  material: { stiffness: 1, damping: 0, static_friction: 0, dynamic_friction: 0 },
  moves: false,
  control: null,
});
const kWalls = { from_m: -0.05, to_m: 0.05 };
const span = (points: Vec3[], axis: number) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))];
const near = (found: number[], wanted: number[]) =>
  assert.ok(
    found.every((value, i) => Math.abs(value - wanted[i]) < 1e-5),
    `${found} is not ${wanted}`,
  );

test('a floor alone reaches beyond an arm; its grid has lines both ways, 2 cm apart', () => {
  const { corners, lines } = plane_patch([plane([0, 0, 1], -0.03)], 0, kWalls);
  near(span(corners, 0), [-0.3, 0.3]);
  near(span(corners, 2), [-0.03, -0.03]);
  const ys = new Set(lines.filter(([a, b]) => Math.abs(a[1] - b[1]) < 1e-9).map(([a]) => Math.round(a[1] * 1000)));
  const xs = new Set(lines.filter(([a, b]) => Math.abs(a[0] - b[0]) < 1e-9).map(([a]) => Math.round(a[0] * 1000)));
  assert.ok(ys.size >= 29 && xs.size >= 29, `${xs.size} and ${ys.size} lines`);
  assert.ok([...ys].every((y) => y % 20 === 0));
});

test('in a room floor and walls end at each other, and walls at the height that is asked for', () => {
  const room = [
    plane([0, 0, 1], -0.03),
    plane([-1, 0, 0], -0.04),
    plane([1, 0, 0], -0.04),
    plane([0, -1, 0], -0.04),
    plane([0, 1, 0], -0.04),
  ];
  const floor = plane_patch(room, 0, kWalls).corners;
  near([...span(floor, 0), ...span(floor, 1)], [-0.04, 0.04, -0.04, 0.04]);
  const right = plane_patch(room, 1, kWalls).corners;
  near([...span(right, 0), ...span(right, 1), ...span(right, 2)], [0.04, 0.04, -0.04, 0.04, -0.03, 0.05]);
});

test('corners go counter-clockwise about the normal, in the frame of an object that stands askew', () => {
  const quarter = [Math.SQRT1_2, 0, Math.SQRT1_2, 0] as const; // about y: z becomes x
  const { corners } = plane_patch([plane([0, 0, 1], 0.01, [0.02, 0, 0], quarter)], 0, kWalls);
  near(span(corners, 2), [0.01, 0.01]);
  const area = corners.reduce((sum, a, i) => {
    const b = corners[(i + 1) % corners.length];
    return sum + (a[0] * b[1] - a[1] * b[0]) / 2;
  }, 0);
  assert.ok(area > 0, `${area}`);
});

test('a plane that lies behind another shows nothing', () => {
  assert.deepEqual(plane_patch([plane([0, 0, 1], 0), plane([-1, 0, 0], 1)], 0, kWalls).corners, []);
});

test('the spline of a stiffness map: a linear map is itself, a lone knot has 4/9 of its height', () => {
  const map = { columns: 7, rows: 7, cell_m: 0.01, origin_m: [0, 0, 0] as const, u: [1, 0, 0] as const, v: [0, 1, 0] as const };
  const linear = { ...map, stiffness_N_m: Float32Array.from({ length: 49 }, (_, i) => 100 + 10 * (i % 7) + 3 * Math.floor(i / 7)) };
  near([spline(linear, 2.3, 3.6)], [100 + 23 + 10.8]);
  const lone = { ...map, stiffness_N_m: Float32Array.from({ length: 49 }, (_, i) => (i === 24 ? 1 : 0)) };
  near([spline(lone, 3, 3), spline(lone, 4, 3), spline(lone, 5, 3)], [4 / 9, 1 / 9, 0]);
});
