// Where surfaces are, and the way out of an object.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { compile } from '../../mock/server';
import { depth_color, kFarColor, kNearColor, kTouchColor } from '../../src/depth_marks';
import type { State } from '../../src/protocol';
import { type ObjectModel, type ShapeModel, read_scene_image } from '../../src/scene_image';
import { SceneObjects } from '../../src/scene_objects';
import type { SurfacePoint } from '../../src/surfaces';
import type { Quat, Vec3 } from '../../src/vector';
import { inside_text, way_out, way_text } from '../../src/way_out';

const material = { stiffness: 1, damping: 0, static_friction: 0, dynamic_friction: 0 };
const object = (name: string, shape: ShapeModel, position_m: Vec3 = [0, 0, 0], rotation: Quat = [1, 0, 0, 0]): ObjectModel => ({
  ...{ name, shape, position_m, rotation, material },
  ...{ texture: null, stiffness_map: null, moves: true, control: null },
});
const scene = (...objects: ObjectModel[]) => new SceneObjects({ name: '', tip_radius_m: 0, objects, triangles: 0 }, 1);
const floor = object('floor', { kind: 'plane', normal: [0, 0, 1], offset_m: -0.05 });
const box: ShapeModel = { kind: 'box', half_size_m: [0.02, 0.01, 0.01] };

function is_at(it: SurfacePoint | null, object: number, point: Vec3, normal: Vec3, distance_m: number): void {
  assert.ok(it);
  assert.equal(it.object, object);
  const near = (a: readonly number[], b: readonly number[]) => a.every((value, i) => Math.abs(value - b[i]) < 2e-5);
  assert.ok(near([...it.point, ...it.normal, it.distance_m], [...point, ...normal, distance_m]), JSON.stringify(it));
}

test('nearest and below: planes, boxes, balls, also inside', () => {
  const { surfaces } = scene(floor, object('box', box, [0, 0, -0.03]), object('ball', { kind: 'sphere', radius_m: 0.01 }, [0.1, 0, 0]));
  is_at(surfaces.nearest([0, 0, 0]), 1, [0, 0, -0.02], [0, 0, 1], 0.02);
  is_at(surfaces.below([0, 0, 0]), 1, [0, 0, -0.02], [0, 0, 1], 0.02);
  is_at(surfaces.below([0.03, 0, 0]), 0, [0.03, 0, -0.05], [0, 0, 1], 0.05);
  is_at(surfaces.nearest([0, 0, -0.021]), 1, [0, 0, -0.02], [0, 0, 1], -0.001);
  is_at(surfaces.nearest([0.3, 0, -0.06], 0), 0, [0.3, 0, -0.05], [0, 0, 1], -0.01);
  assert.ok(Math.abs((surfaces.nearest([0.1, 0, 0.02]) as SurfacePoint).distance_m - 0.01) < 5e-5);
  assert.equal(scene().surfaces.nearest([0, 0, 0]), null);
});

test('a body is asked where it is now, turned as it is now', () => {
  const objects = scene(object('box', box));
  const half = Math.SQRT1_2;
  const state: State = {
    type: 'state',
    time_s: 0,
    arms: [],
    bodies: [{ object: 0, position_m: [0, 0, 0.1], rotation: [half, 0, half, 0] }],
  };
  objects.update(state); // its long side is upright
  is_at(objects.surfaces.below([0, 0, 0.2]), 0, [0, 0, 0.12], [0, 0, 1], 0.08);
  is_at(objects.surfaces.nearest([0, 0, 0.2]), 0, [0, 0, 0.12], [0, 0, 1], 0.08);
});

test('fields are no surfaces; tissue is one, and sinks', () => {
  const fields = new SceneObjects(read_scene_image(compile('potential')), 1).surfaces;
  assert.equal(fields.nearest([0, 0, 0]), null);
  assert.equal(fields.below([0, 0, 0.1]), null);
  const objects = scene(object('pad', { kind: 'tissue', half_x_m: 0.05, half_y_m: 0.05, contact_radius_m: 0.005 }));
  is_at(objects.surfaces.below([0.01, 0, 0.02]), 0, [0.01, 0, 0], [0, 0, 1], 0.02);
  const pressed = { object: 0, arm: 0, pressed: true, at_m: [0, 0] as const, depth_m: 0.004 };
  objects.update({ type: 'state', time_s: 0, arms: [], tissues: [pressed] });
  is_at(objects.surfaces.nearest([0, 0, -0.004]), 0, [0, 0, -0.004], [0, 0, 1], 0);
});

test('of a mesh of many triangles the nearest point is as near as of all of them', () => {
  const model = read_scene_image(compile('asteroid'));
  const { surfaces } = new SceneObjects(model, 1);
  const mesh = model.objects[0].shape;
  assert.ok(mesh.kind === 'mesh');
  const at: Vec3 = [0.03, -0.02, 0.06];
  let vertex_m = Infinity;
  for (let i = 0; i < mesh.positions.length; i += 3)
    vertex_m = Math.min(vertex_m, Math.hypot(...at.map((value, k) => value - mesh.positions[i + k] - model.objects[0].position_m[k])));
  const found = surfaces.nearest(at) as SurfacePoint;
  assert.ok(found.distance_m > 0 && found.distance_m <= vertex_m && found.distance_m > 0.5 * vertex_m, `${found.distance_m} ${vertex_m}`);
});

test('colours: far, near, touching', () => {
  assert.equal(depth_color(1, false).getHex(), kFarColor);
  assert.equal(depth_color(1e-9, false).getHex(), kNearColor);
  assert.equal(depth_color(0.01, true).getHex(), kTouchColor);
  assert.equal(depth_color(-0.001, false).getHex(), kTouchColor);
});

test('what a tip has to leave is told by name, with the way', () => {
  const { surfaces } = scene(floor, object('lamp', box, [0, 0, -0.03]));
  const way = (tip_m: Vec3, object: number) => way_out(surfaces, tip_m, object, 0);
  const at = (arms: State['arms']): State => ({ type: 'state', time_s: 0, arms });
  const names = ['floor', 'lamp'];
  assert.equal(inside_text(at([]), names, way), '');
  assert.equal(inside_text(at([{ tip_m: [0.018, 0, -0.03], inside: [1] }]), names, way), 'Inside: move right by 2 mm to leave lamp.');
  assert.equal(
    inside_text(at([null, { tip_m: [0, 0, -0.06], inside: [0, 5] }]), names, way),
    'Arm 1 is inside: move up by 10 mm to leave floor. Arm 1 is inside: move out to leave object 5.',
  );
  assert.equal(way_text([-0.003, 0.003, 0.0001]), 'left and away from you by 5 mm');
  // A tip with a radius is out when all of it is.
  assert.deepEqual(
    way_out(surfaces, [0, 0, -0.051], 0, 0.004)?.map((it) => Math.round(it * 1e6)),
    [0, 0, 5000],
  );
});
