// How far a drag down is from home to the first force, in every demonstration; and that drags are predictable.
import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { Vector3 } from 'three';

import { compile, kTop } from '../../mock/server';
import { type View, hand_axes, kDrag_px, kNoReach, reach_of } from '../../src/drag_mapping';
import { kSeat, pixel_m_at, view_of } from '../../src/framing';
import { HandControl } from '../../src/hand_control';
import { read_scene_image } from '../../src/scene_image';
import { SceneObjects } from '../../src/scene_objects';
import type { Stage } from '../../src/stage';
import { type Vec3, dot, length, sub } from '../../src/vector';

const kView_px = { columns: 874, rows: 508 }; // of the page in a window of 1280 x 800
const kMost_px = 90;
const kHome: Vec3 = [0, 0, 0];

// As the camera sees it that a scene begins with, so much nearer or farther.
function view(distance_m: number, zoom = 1): View {
  const right = new Vector3(0, 0, 1).cross(kSeat).normalize();
  const up = new Vector3().crossVectors(kSeat, right);
  const [r, u, away] = [right, up, kSeat.clone().negate()].map((it) => it.toArray() as Vec3);
  return { right: r, up: u, away, pixel_m: pixel_m_at(zoom * distance_m, kView_px.rows), zoom };
}

// A hand at home that is dragged, in steps of a pixel; what it wishes after each.
function hand_of(objects: SceneObjects, now: View) {
  const listeners = new Map<string, (event: object) => void>();
  const canvas = {
    addEventListener: (name: string, it: (event: object) => void) => listeners.set(name, it),
    focus() {},
    setPointerCapture() {},
  };
  let at = kHome;
  const hand = new HandControl({ canvas, drag_turns() {}, view: () => now } as unknown as Stage, (_, position_m) => (at = position_m));
  hand.enable(true);
  hand.reaches = [reach_of(objects.surfaces, kHome)];
  hand.follow(0, kHome);
  let [x, y, seconds] = [0, 0, 0];
  const pointer = (name: string) =>
    listeners.get(name)?.({ pointerId: 1, button: 0, clientX: x, clientY: y, preventDefault() {}, stopImmediatePropagation() {} });
  pointer('pointerdown');
  return (dx: number, dy: number): Vec3 => {
    [x, y, seconds] = [x + dx, y + dy, seconds + 1];
    pointer('pointermove');
    hand.follow(0, at);
    hand.step(seconds, 0.01);
    return at;
  };
}

const scenes = readdirSync(join(kTop, 'scenes'), { recursive: true }).map(String);
for (const file of scenes.filter((name) => name.endsWith('.scene.json'))) {
  test(`${file}: dragged down from home the tip meets the scene within ${kMost_px} pixels`, () => {
    const model = read_scene_image(compile(join(kTop, 'scenes', file)));
    const objects = new SceneObjects(model, 1);
    const { distance_m } = view_of(objects.bounds, kView_px.columns / kView_px.rows);
    const drag = hand_of(objects, view(distance_m));
    const felt = (at: Vec3) => {
      const nearest = objects.surfaces.nearest(at);
      if (nearest !== null && nearest.distance_m <= 0) return true;
      // Fields have no inside here: the drawn face has been passed.
      const way = objects.surfaces.along(kHome, [0, 0, -1], true);
      return way !== null && at[2] <= way.point[2];
    };
    assert.ok(!felt(kHome), 'it is felt at home');
    let pixels = 0;
    while (!felt(drag(0, 1))) assert.ok(++pixels < kMost_px, `nothing after ${pixels} pixels`);
    console.log(`# ${file}: ${pixels + 1} pixels`);
  });
}

test('equal drags are equal motions, up undoes down, left undoes right, and nearer is finer', () => {
  const objects = new SceneObjects(read_scene_image(compile('smooth')), 1); // dragged aslant
  const drag = hand_of(objects, view(0.5));
  const steps = [
    [0, 20],
    [0, 20],
    [15, 0],
    [-15, 0],
    [0, -40],
  ].map(([dx, dy]) => drag(dx, dy));
  const [first, second, right, left, back] = steps;
  const near = (a: Vec3, b: Vec3) => assert.ok(length(sub(a, b)) < 1e-12, `${a} and ${b}`);
  near(sub(second, first), first);
  near(left, second);
  near(back, kHome);
  assert.ok(right[0] > second[0] && Math.abs(right[2] - second[2]) < 1e-12, 'to the right is level');
  assert.ok(first[2] < -0.8 * length(first), 'down is mainly down');
  const [whole, half] = [view(0.5), view(0.5, 0.5)].map((it) => length(hand_of(objects, it)(0, 10)));
  assert.ok(Math.abs(half / whole - 0.5) < 1e-9, `${whole} m and, from half as far, ${half} m for 10 pixels`);
});

test('a drag to the side and the wheel move along the grid, from whatever side the scene is seen; a drag up and the wheel are told apart', () => {
  const first = hand_axes(view(1), kNoReach);
  assert.deepEqual(
    [first.right, first.away],
    [
      [1, 0, 0],
      [0, 1, 0],
    ],
  );
  for (let turn_deg = 5; turn_deg < 360; turn_deg += 10) {
    const turned = (it: Vec3) => new Vector3(...it).applyAxisAngle(new Vector3(0, 0, 1), (turn_deg * Math.PI) / 180).toArray() as Vec3;
    const screen = { right: turned([1, 0, 0]), up: turned([0, 0.5, 0.866]), away: turned([0, 0.866, -0.5]) };
    const { right, up, away } = hand_axes(screen, kNoReach);
    for (const axis of [right, away]) assert.deepEqual(axis.map(Math.abs).sort(), [0, 0, 1], `${turn_deg} degrees: ${axis}`);
    assert.ok(dot(right, screen.right) > 0.7 && dot(away, screen.away) > 0.6, `${turn_deg} degrees: ${right}, ${away}`);
    assert.ok(Math.abs(up[2]) === 1 && right[2] === 0 && away[2] === 0);
  }
});

test('seen from above a drag up moves away over the grid, and depth is the height; nothing to reach leaves the pixels as they are', () => {
  const axes = { right: [1, 0, 0], up: [0, 1, 0], away: [0, 0, -1] } as const;
  assert.deepEqual(hand_axes(axes, kNoReach), axes);
  assert.deepEqual(hand_axes(view(1), kNoReach).up.map(Math.abs), [0, 0, 1]);
  assert.ok(kDrag_px < kMost_px);
});
