// The scene image is read as the compiler wrote it; $THIMBLE names the compiler (mock/server.ts).
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import { compile } from '../../mock/server';
import { build_parts } from '../../src/geometry';
import { decode_octahedral } from '../../src/octahedral';
import { type SceneModel, read_scene_image } from '../../src/scene_image';
import { kTop } from '../real/command';

const near = (a: number, b: number, tolerance: number, what = '') => assert.ok(Math.abs(a - b) <= tolerance, `${what} ${a} is not ${b}`);
const scene = (name: string): SceneModel => read_scene_image(compile(name));

test('blocks: a plane and two boxes that move', () => {
  const { name, tip_radius_m, objects } = scene('blocks');
  assert.equal(name, 'blocks');
  assert.equal(tip_radius_m, 0);
  assert.deepEqual(
    objects.map((it) => [it.name, it.shape.kind, it.moves]),
    [
      ['table', 'plane', false],
      ['near block', 'box', true],
      ['far block', 'box', true],
    ],
  );
  const [table, block] = objects;
  assert.ok(table.shape.kind === 'plane' && block.shape.kind === 'box');
  near(table.shape.offset_m, -0.05, 1e-7);
  near(block.shape.half_size_m[0], 0.015, 1e-7);
  near(block.position_m[1], -0.03, 1e-7);
  assert.deepEqual(block.rotation, [1, 0, 0, 0]);
  assert.equal(block.material.stiffness, 1000);
  near(block.material.static_friction, 0.8, 1e-6);
});

test('smooth: a mesh whose corner normals are unit vectors and near those of its faces', () => {
  const mesh = scene('smooth')
    .objects.map((it) => it.shape)
    .find((it) => it.kind === 'mesh');
  assert.ok(mesh?.kind === 'mesh');
  const { positions: p, normals, indices } = mesh;
  assert.ok(normals !== null && normals.length === p.length);
  let least = 1;
  for (let i = 0; i < indices.length; i += 3) {
    const [u, v, w] = [...indices.subarray(i, i + 3)].map((vertex) => vertex * 3);
    const a = [0, 1, 2].map((k) => p[v + k] - p[u + k]);
    const b = [0, 1, 2].map((k) => p[w + k] - p[u + k]);
    const n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    for (const at of [u, v, w]) {
      near(Math.hypot(normals[at], normals[at + 1], normals[at + 2]), 1, 1e-5, 'length');
      least = Math.min(least, (n[0] * normals[at] + n[1] * normals[at + 1] + n[2] * normals[at + 2]) / Math.hypot(...n));
    }
  }
  assert.ok(least > 0.3, `a corner normal stands at a cosine of ${least} to its face`);
});

test('a faceted mesh has no normals of its own, and every vertex once', () => {
  const { objects, triangles } = scene('asteroid');
  const mesh = objects[0].shape;
  assert.ok(mesh.kind === 'mesh' && mesh.normals === null && triangles > 100);
  // Euler's formula of a closed surface: V - E + F = 2, E = 3 F / 2.
  assert.equal(mesh.positions.length / 3 - triangles / 2, 2);
});

test('fields, needle, tissue and controls', () => {
  const shape = (name: string, kind: string) =>
    scene(name)
      .objects.map((it) => it.shape)
      .find((it) => it.kind === kind);
  const field = shape('vector-fields', 'vector_field');
  assert.ok(field?.kind === 'vector_field' && field.subvolumes.length > 0 && field.hi_m[0] > field.lo_m[0]);
  const potential = shape('potential', 'potential_field');
  assert.ok(potential?.kind === 'potential_field' && potential.step_m > 0);
  const needle = shape('needle', 'needle');
  assert.ok(needle?.kind === 'needle' && needle.layers.length > 1 && needle.layers.every((it) => it.thickness_m > 0));
  const tissue = shape('deform', 'tissue');
  assert.ok(tissue?.kind === 'tissue');
  near(tissue.half_x_m, 0.06, 1e-7);
  near(tissue.contact_radius_m, 0.006, 1e-7);
  const controls = scene('buttons').objects.flatMap((it) => (it.control ? [it.control] : []));
  assert.ok(controls.some((it) => it.turns) && controls.some((it) => !it.turns));
  for (const { axis } of controls) near(Math.hypot(...axis), 1, 1e-5, 'axis');
});

test('primitive shapes: the lengths of the scene file, and drawn where the solid is', () => {
  const shapes = {
    sphere: { radius_m: 0.02 },
    box: { size_m: [0.02, 0.04, 0.06] },
    cylinder: { radius_m: 0.01, height_m: 0.05 },
    capsule: { radius_m: 0.01, height_m: 0.05 },
    cone: { radius_m: 0.02, height_m: 0.04 },
  };
  // Half the width along x, the lowest and the highest z of each.
  const drawn: Record<string, number[]> = {
    sphere: [0.02, -0.02, 0.02],
    box: [0.01, -0.03, 0.03],
    cylinder: [0.01, -0.025, 0.025],
    capsule: [0.01, -0.035, 0.035],
    cone: [0.02, -0.01, 0.03],
  };
  const folder = mkdtempSync(join(tmpdir(), 'thimble-shapes-'));
  try {
    const file = join(folder, 'shapes.scene.json');
    const objects = Object.entries(shapes).map(([name, of]) => ({ name, shape: { [name]: of }, material: { stiffness_N_m: 500 } }));
    writeFileSync(file, JSON.stringify({ thimble_scene: 1, name: 'shapes', tip_radius_m: 0.003, objects }));
    near(scene(file).tip_radius_m, 0.003, 1e-9);
    for (const { name, shape } of scene(file).objects) {
      assert.equal(shape.kind, name);
      if (shape.kind === 'cone') near(shape.height_m, 0.04, 1e-8);
      const [{ geometry }] = build_parts(shape);
      geometry.computeBoundingBox();
      const box = geometry.boundingBox;
      assert.ok(box);
      [box.max.x, box.min.z, box.max.z].forEach((value, i) => near(value, drawn[name][i], 1e-6, name));
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('textures and stiffness maps: the numbers of the scene files', () => {
  const { texture, stiffness_map } = scene('textures').objects[0];
  assert.equal(stiffness_map, null);
  assert.ok(texture);
  texture.tile_m.forEach((size) => near(size, 0.004, 1e-8));
  assert.equal(texture.height_m.length, texture.columns * texture.rows);
  assert.ok(Math.max(...texture.height_m) < 1e-3 && Math.min(...texture.height_m) < 0);
  const map = scene('spline-tissue').objects[0].stiffness_map;
  assert.ok(map);
  assert.deepEqual([map.columns, map.rows], [17, 13]);
  near(map.cell_m, 0.005, 1e-8);
  const rows = readFileSync(join(kTop, 'scenes/spline-tissue/stiffness.csv'), 'utf8').trim().split('\n').reverse();
  const values = rows.flatMap((row) => row.split(',').map(Number)); // the last row is at the least v
  map.stiffness_N_m.forEach((value, i) => near(value, values[i], 1e-4));
});

test('what is no image, or is cut short, is refused with a word', () => {
  assert.throws(() => read_scene_image(new Uint8Array()), /no scene image/);
  assert.throws(() => read_scene_image(new TextEncoder().encode('<!doctype html><html></html>')), /no scene image/);
  const bytes = compile('asteroid');
  let refused = 0;
  for (let size = 0; size < bytes.length; size += Math.ceil(bytes.length / 200)) {
    try {
      read_scene_image(bytes.slice(0, size));
    } catch (error) {
      assert.ok(error instanceof Error && /scene image/.test(error.message), String(error));
      ++refused;
    }
  }
  assert.ok(refused > 100, `${refused} of 200 cuts were refused`); // the tree behind the triangles is not read
});

test('octahedral normals: the six axes, and the lower half', () => {
  const out = new Float32Array(3);
  const pack = (x: number, y: number) => ((Math.round(x * 32767) & 0xffff) | ((Math.round(y * 32767) & 0xffff) << 16)) >>> 0;
  const decode = (x: number, y: number) => {
    decode_octahedral(pack(x, y), out, 0);
    return [...out];
  };
  assert.deepEqual(decode(1, 0), [1, 0, 0]);
  assert.deepEqual(
    decode(0, -1).map((it) => it + 0),
    [0, -1, 0],
  );
  assert.deepEqual(decode(0, 0), [0, 0, 1]);
  decode(1, 1).forEach((value, i) => near(value, [0, 0, -1][i], 1e-4));
  decode(0.75, 0.75).forEach((value, i) => near(value, [0.4082, 0.4082, -0.8165][i], 1e-3));
});
