// Writes src/generated: the reader of scene images, which flatc makes from control/scene/scene.fbs.
//
// flatc 2.0 (Debian 12) has no fixed arrays in TypeScript. Single fields have the same place in the struct, so `vertex:[uint:3]` becomes
// `vertex_0:uint; vertex_1:uint; vertex_2:uint;` in a copy of the schema. And each release of flatc names the file that has all types in another
// way, so it is written here.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const page = dirname(dirname(fileURLToPath(import.meta.url)));
const schema = join(page, '../../../control/scene/scene.fbs');
const generated = join(page, 'src/generated');

const text = readFileSync(schema, 'utf8').replace(/(\w+):\[(\w+):(\d+)\];/g, (_, name, type, count) =>
  Array.from({ length: Number(count) }, (_, i) => `${name}_${i}:${type};`).join(' '),
);

rmSync(generated, { recursive: true, force: true });
mkdirSync(generated, { recursive: true });
writeFileSync(join(generated, 'scene.fbs'), text);
try {
  execFileSync('flatc', ['--ts', '-o', generated, join(generated, 'scene.fbs')], { stdio: ['ignore', 'inherit', 'inherit'] });
} catch (error) {
  if (error.code !== 'ENOENT') process.exit(1);
  console.error('flatc is not installed\n  remedy: apt-get install flatbuffers-compiler');
  process.exit(1);
}
const types = readdirSync(join(generated, 'thimble/scene')).sort();
writeFileSync(
  join(generated, 'scene_generated.ts'),
  types.map((file) => `export * from './thimble/scene/${file.replace(/\.ts$/, '')}';\n`).join(''),
);
