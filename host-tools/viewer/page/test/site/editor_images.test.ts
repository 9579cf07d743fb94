// What the editor makes of a scene compiles to the bytes of a scene that was written so from the start.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { apply } from '../../src/editor/json_edits';
import * as edits from '../../src/editor/scene_edits';
import { type Scene, kSceneTexts, value_of, with_comments } from '../unit/editor_texts';
import { compiler_of_scenes } from './modules';

const kSmall = /^(walls|buttons|ring|sliders|blocks|textures|ice)\//; // what compiles in no time

test('edited texts and rewritten scenes have the same images', () => {
  const compiler = compiler_of_scenes();
  let images = 0;
  const image = (file: string, text: string): Buffer => {
    const { head, image: bytes } = compiler.compile(`/scenes/${file}`, text);
    assert.deepEqual(head.issues, [], file);
    ++images;
    return Buffer.from(bytes);
  };
  for (const { name, text: plain } of kSceneTexts.filter((scene) => kSmall.test(scene.name))) {
    const text = with_comments(plain);
    const last = value_of(text).objects.length - 1;
    const [x, y, z] = edits.outline(text).objects[last].position_m;
    const moved = apply(text, edits.move(text, last, [x, y, z + 0.001]));
    const softer = apply(moved, edits.set_material(moved, last, 'stiffness_N_m', 321));
    assert.deepEqual(image(name, softer), image(name, JSON.stringify(rewritten(plain, last))), name);
    assert.notDeepEqual(image(name, softer), image(name, plain), name);
  }
  assert.ok(images >= 24);
});

function rewritten(plain: string, last: number): Scene {
  const scene = value_of(plain);
  const object = scene.objects[last];
  const at = object.pose?.position_m ?? [0, 0, 0];
  object.pose = { ...object.pose, position_m: [at[0], at[1], Number((at[2] + 0.001).toFixed(6))] };
  if (object.body?.pivot_m) object.body.pivot_m[2] = Number((object.body.pivot_m[2] + 0.001).toFixed(6));
  const material = typeof object.material === 'string' ? scene.materials?.[object.material] : object.material;
  if (material) material.stiffness_N_m = 321;
  return scene;
}
