// What the editor does to the text of a scene: each of its operations, on all scenes of scenes/, as they are and with comments at every place. What
// an operation means is written here a second time, on the value.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { history, undo } from '@codemirror/commands';
import { EditorState } from '@codemirror/state';

import { type Edit, apply, insert_element, print, remove_element, set_value } from '../../src/editor/json_edits';
import * as edits from '../../src/editor/scene_edits';
import { outline_of } from '../../src/editor/scene_outline';
import { kAddable, object_of_file, object_to_add } from '../../src/editor/templates';
import { type Scene, type SceneObject, kSceneTexts, remarks, value_of, with_comments } from './editor_texts';

const near = (value: number): number => Number(value.toFixed(6)) + 0;

// After the change and its undo.
function undone(text: string, change: readonly Edit[]): string {
  let state = EditorState.create({ doc: text, extensions: [history(), EditorState.lineSeparator.of('\n')] });
  const changes = change.map(({ offset, length, content }) => ({ from: offset, to: offset + length, insert: content }));
  state = state.update({ changes }).state;
  assert.equal(state.sliceDoc(), apply(text, change));
  undo({ state, dispatch: (transaction) => (state = transaction.state) });
  return state.sliceDoc();
}

interface Operation {
  name: string;
  edit(text: string, index: number): Edit[];
  mean(scene: Scene, index: number): void; // the same on the value
  loses?: boolean; // comments inside of the object
}

const pose_of = (object: SceneObject) => (object.pose ??= {});

function mean_moved(object: SceneObject, by: number[]): void {
  const from = object.pose?.position_m ?? [0, 0, 0];
  pose_of(object).position_m = from.map((at, i) => near(at + by[i]));
  const { body } = object;
  if (body?.pivot_m) body.pivot_m = body.pivot_m.map((at, i) => near(at + by[i]));
}

const kBy = [0.0123, -0.004, 0.0005];
const kOperations: Operation[] = [
  {
    name: 'move',
    edit: (text, index) => {
      const [x, y, z] = edits.outline(text).objects[index].position_m;
      return edits.move(text, index, [x + kBy[0], y + kBy[1], z + kBy[2]]);
    },
    mean: (scene, index) => mean_moved(scene.objects[index], kBy),
  },
  {
    name: 'turn',
    edit: (text, index) => edits.turn(text, index, [10.5, 0, -45.1234]),
    mean: (scene, index) => void (pose_of(scene.objects[index]).rotation_deg = [10.5, 0, -45.123]),
  },
  {
    name: 'scale',
    edit: (text, index) => edits.scale(text, index, [2, 2, 2]),
    mean: (scene, index) => {
      const [kind, shape] = Object.entries(scene.objects[index].shape)[0];
      if (kind === 'mesh') shape.scale = edits.rounded(2 * ((shape.scale as number | undefined) ?? 1));
      const keys = ['sphere', 'box', 'cylinder', 'capsule', 'cone', 'height_field'].includes(kind)
        ? ['radius_m', 'size_m', 'height_m']
        : [];
      for (const key of keys) {
        const value = shape[key];
        if (Array.isArray(value)) shape[key] = value.map((one) => near(2 * one));
        else if (typeof value === 'number') shape[key] = near(2 * value);
      }
    },
  },
  {
    name: 'rename',
    edit: (text, index) => edits.rename(text, index, 'a "new" name'),
    mean: (scene, index) => void (scene.objects[index].name = 'a "new" name'),
  },
  {
    name: 'duplicate',
    edit: (text, index) => edits.duplicate(text, index),
    mean: (scene, index) => {
      const copy = structuredClone(scene.objects[index]);
      const stem = copy.name.replace(/ \d+$/, '');
      for (let number = 2; scene.objects.some((object) => object.name === copy.name); ++number) copy.name = `${stem} ${number}`;
      mean_moved(copy, [0.02, 0, 0]);
      scene.objects.splice(index + 1, 0, copy);
    },
  },
  {
    name: 'remove',
    edit: (text, index) => edits.remove(text, index),
    mean: (scene, index) => void scene.objects.splice(index, 1),
    loses: true,
  },
  {
    name: 'set a number of the material',
    edit: (text, index) => edits.set_material(text, index, 'damping_N_s_m', 1.25),
    mean: (scene, index) => {
      const { material } = scene.objects[index];
      const found = typeof material === 'string' ? scene.materials?.[material] : material;
      if (found) found.damping_N_s_m = 1.25;
    },
  },
  {
    name: 'name the material',
    edit: (text, index) => edits.name_material(text, index, 'new'),
    mean: (scene, index) => {
      const { material } = scene.objects[index];
      if (typeof material === 'string') {
        scene.materials = Object.fromEntries(
          Object.entries(scene.materials ?? {}).map(([name, of]) => [name === material ? 'new' : name, of]),
        );
        for (const object of scene.objects) if (object.material === material) object.material = 'new';
      } else {
        (scene.materials ??= {}).new = material;
        scene.objects[index].material = 'new';
      }
    },
  },
  {
    name: 'a material of its own',
    edit: (text, index) => edits.own_material(text, index),
    mean: (scene, index) => {
      const { material } = scene.objects[index];
      if (typeof material === 'string') scene.objects[index].material = structuredClone(scene.materials?.[material] ?? {});
    },
  },
];

for (const { name, edit, mean, loses } of kOperations) {
  test(`${name}: on every object of every scene, and back`, () => {
    for (const { name: file, text: plain } of kSceneTexts) {
      for (const text of [plain, with_comments(plain)]) {
        const indices = outline_of(text)?.objects.map((object) => object.index) ?? [];
        for (const index of indices.filter((one) => one === 0 || (text === plain && one === indices.length - 1))) {
          const where = `${file}, object ${index}`;
          const change = edit(text, index);
          const changed = apply(text, change);
          const expected = value_of(text);
          mean(expected, index);
          assert.deepEqual(value_of(changed), expected, where);
          assert.equal(undone(text, change), text, where);
          if (loses) continue;
          const kept = new Set(remarks(changed));
          assert.deepEqual(
            remarks(text).filter((remark) => !kept.has(remark)),
            [],
            where,
          );
        }
      }
    }
  });
}

test('what is removed takes only its own comments along', () => {
  const text = '{"objects": [\n  // one\n  {"name": "a" /* in a */}, // of a\n  // two\n  {"name": "b"} // of b\n  // end\n]}';
  const names = (now: string) => value_of(now).objects.map((object) => object.name);
  const without_a = apply(text, edits.remove(text, 0));
  assert.deepEqual(names(without_a), ['b']);
  const without_b = apply(text, edits.remove(text, 1));
  assert.deepEqual(names(without_b), ['a']);
  for (const remark of ['// one', '// of a', '// two', '// of b', '// end']) {
    assert.ok(without_a.includes(remark), remark);
    assert.ok(without_b.includes(remark), remark);
  }
  assert.deepEqual(names(apply(without_b, edits.remove(without_b, 0))), []);
});

test('what can be added, into a scene with objects and one without', () => {
  for (const { text } of [...kSceneTexts, { text: '{"objects": []}' }, { text: '{"objects": [ // none\n]}' }]) {
    for (const name of kAddable) {
      const part = object_to_add(name, outline_of(text));
      const change = edits.add(text, part);
      const expected = value_of(text);
      expected.objects.push({ ...(structuredClone(part) as unknown as SceneObject), name: edits.free_name(text, name) });
      assert.deepEqual(value_of(apply(text, change)), expected);
      assert.equal(undone(text, change), text);
    }
  }
});

test('new lines are written like their neighbours, and a remark stays at its value', () => {
  const text = '{\r\n\t"a": 1, // of a\r\n\t"b": 2 // of b\r\n}\r\n';
  assert.equal(apply(text, set_value(text, ['c'], [1, 2])), '{\r\n\t"a": 1, // of a\r\n\t"b": 2, // of b\r\n\t"c": [1, 2]\r\n}\r\n');
  const line = '{ "a": { "b": 1 }, "c": [1, 2.0, 3] }';
  assert.equal(apply(line, set_value(line, ['a', 'd', 'e'], true)), '{ "a": { "b": 1, "d": { "e": true } }, "c": [1, 2.0, 3] }');
  assert.equal(apply(line, set_value(line, ['c'], [1, 2, 4])), '{ "a": { "b": 1 }, "c": [1, 2.0, 4] }');
  assert.equal(apply(line, insert_element(line, ['c'], '9', 0)), '{ "a": { "b": 1 }, "c": [1, 9, 2.0, 3] }');
  assert.equal(apply(line, remove_element(line, ['c'], 2)), '{ "a": { "b": 1 }, "c": [1, 2.0] }');
  assert.equal(print({ a: [], b: {}, c: 'x"' }), '{ "a": [], "b": {}, "c": "x\\"" }');
});

test('an edit of nothing changes nothing', () => {
  for (const { text } of kSceneTexts) {
    for (const object of outline_of(text)?.objects ?? []) {
      assert.deepEqual(edits.move(text, object.index, object.position_m), []);
      assert.deepEqual(edits.turn(text, object.index, object.rotation_deg), []);
      assert.deepEqual(edits.scale(text, object.index, [1, 1, 1]), []);
      assert.deepEqual(edits.rename(text, object.index, object.name), []);
      object.sizes.forEach((size, i) => assert.deepEqual(edits.resize(text, object.index, i, size.value), []));
    }
  }
});

test('texts that are none are refused, not mended', () => {
  for (const text of ['', '{', '[]', '{"objects": 1}', '// nothing']) {
    assert.equal(outline_of(text)?.objects.length ?? 0, 0);
    assert.throws(() => edits.move(text, 0, [0, 0, 1]));
    assert.throws(() => edits.remove(text, 0));
  }
  assert.equal(object_of_file('part.bin', null), null);
  assert.equal(object_of_file('part.OBJ', null)?.name, 'part');
});

test('the one edit between two texts', () => {
  for (const [from, to] of [
    ['abc', 'abc'],
    ['aaa', 'aa'],
    ['aa', 'aaa'],
    ['', 'x'],
    ['abcd', 'axd'],
  ])
    assert.equal(apply(from, edits.whole(from, to)), to);
});
