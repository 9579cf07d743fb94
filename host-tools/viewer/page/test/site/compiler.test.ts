// The compiler of the site against the one of this machine: the same images, byte for byte, and the same errors.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, relative } from 'node:path';
import { after, test } from 'node:test';

import type { Compiler } from '../../src/in_page/compiler';
import { bumpy_ball, kFormats } from './mesh_files';
import { all_files, compiler_of_scenes, kScenes, kThimble } from './modules';

const folder = mkdtempSync(join(tmpdir(), 'thimble-site-'));
after(() => rmSync(folder, { recursive: true }));
const kTrailer_bytes = 8; // "CRC1" and the CRC

// compile() of the site's path gives the image that `thimble compile` makes of the file.
function same_as_native(compiler: Compiler, path: string, file: string): void {
  const { head, image } = compiler.compile(path, readFileSync(file, 'utf8'));
  assert.deepEqual(head.issues, [], file);
  const output = join(folder, 'image');
  execFileSync(kThimble, ['compile', file, '--output', output], { stdio: 'ignore' });
  assert.ok(readFileSync(output).subarray(0, -kTrailer_bytes).equals(image), `${file}: other bytes`);
}

test('every scene has the image that `thimble compile` makes of it', () => {
  const compiler = compiler_of_scenes();
  const scenes = all_files(kScenes).filter((file) => file.endsWith('.scene.json'));
  assert.ok(scenes.length >= 24);
  for (const file of scenes) same_as_native(compiler, `/scenes/${relative(kScenes, file)}`, file);
});

for (const [name, { bytes, beside }] of Object.entries(kFormats))
  test(`a mesh of ${name}`, () => {
    const compiler = compiler_of_scenes();
    const solid = bumpy_ball(9);
    const files = { [name]: bytes, ...beside };
    for (const [file, make] of Object.entries(files)) {
      writeFileSync(join(folder, file), make(solid));
      compiler.put_file(`/scenes/mine/${file}`, make(solid));
    }
    const material = { stiffness_N_m: 500 };
    const scene = { thimble_scene: 1, name: 'ball', objects: [{ name: 'ball', shape: { mesh: { file: name, scale: 0.02 } }, material }] };
    const file = join(folder, 'mine.scene.json');
    writeFileSync(file, JSON.stringify(scene));
    same_as_native(compiler, '/scenes/mine/mine.scene.json', file);
  });

test('all errors of a text are told, with their places, and the compiler goes on', () => {
  const compiler = compiler_of_scenes();
  const text = '{\n  "thimble_scene": 1,\n  "name": 3,\n  "objects": [{"name": "a", "shape": "bowl"}]\n}';
  const { head, image } = compiler.compile('/scenes/mine/mine.scene.json', text);
  assert.equal(image.length, 0);
  assert.ok(head.issues.length >= 2, JSON.stringify(head.issues));
  assert.ok(head.issues.every((issue) => issue.cause.includes('mine.scene.json') && issue.remedy !== ''));
  assert.deepEqual(new Set(head.issues.map((issue) => issue.line)), new Set([3, 4]));
  const walls = readFileSync(join(kScenes, 'walls/walls.scene.json'), 'utf8');
  assert.deepEqual(compiler.compile('/scenes/walls/walls.scene.json', walls).head.issues, []);
});
