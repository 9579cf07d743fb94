// The module of the site (host-tools/in_page) and the scenes, for tests in Node.js. SITE: the folder of the site.
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { join, relative } from 'node:path';

import { Compiler } from '../../src/in_page/compiler';

const kRoot = new URL('../../../../../', import.meta.url).pathname;
export const kSite = process.env.SITE ?? join(kRoot, 'build/page/site');
export const kThimble = process.env.THIMBLE ?? join(kRoot, 'build/release/bin/thimble');
export const kScenes = join(kRoot, 'scenes');

export const kModule = new WebAssembly.Module(readFileSync(join(kSite, 'thimble.wasm')));

export function all_files(folder: string): string[] {
  return readdirSync(folder)
    .sort()
    .flatMap((name) => (statSync(join(folder, name)).isDirectory() ? all_files(join(folder, name)) : [join(folder, name)]));
}

// A compiler that has every file of the scenes.
export function compiler_of_scenes(): Compiler {
  const compiler = new Compiler(kModule);
  for (const file of all_files(kScenes)) compiler.put_file(`/scenes/${relative(kScenes, file)}`, readFileSync(file));
  return compiler;
}
