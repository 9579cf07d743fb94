// node make_site.mjs SITE SCENES: puts the scenes of SCENES into the folder of the site, with their list (src/in_page/gallery.ts), and the service
// worker that keeps all files of the site for when there is no network. Prints the size of the site, compressed.
import { createHash } from 'node:crypto';
import { cpSync, existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, normalize, relative } from 'node:path';
import { gzipSync } from 'node:zlib';

const { parse } = createRequire(new URL('../viewer/page/package.json', import.meta.url))('jsonc-parser'); // scenes may hold comments
const [site, scenes] = process.argv.slice(2);

const all_files = (folder) =>
  readdirSync(folder)
    .sort()
    .flatMap((name) => (statSync(join(folder, name)).isDirectory() ? all_files(join(folder, name)) : [join(folder, name)]));

// The files that a scene names, wherever it does: every string with a file of that name beside the scene.
function named_files(file) {
  const found = new Set();
  const look = (value) => {
    if (typeof value === 'string') {
      const path = join(dirname(file), value);
      const name = normalize(relative(scenes, path));
      if (!name.startsWith('..') && existsSync(path) && statSync(path).isFile()) found.add(name);
    } else if (value !== null && typeof value === 'object') Object.values(value).forEach(look);
  };
  look(parse(readFileSync(file, 'utf8')));
  return [...found].sort();
}

const scene_name = (file) => file.split('/').at(-1).replace('.scene.json', '');
// The path of the scripted hand, for how many arms it is, and the picture.
function shown_with(file) {
  const name = scene_name(file);
  const beside = (...names) => names.map((one) => relative(scenes, join(dirname(file), one))).find((one) => existsSync(join(scenes, one)));
  const path = beside(`${name}.stroke.csv`, 'stroke.csv');
  const arms = path !== undefined && /^.*,arm$/m.test(readFileSync(join(scenes, path), 'utf8')) ? 2 : 1;
  return { path, arms, picture: beside(`${name}.webp`) };
}

const list = all_files(scenes)
  .filter((file) => file.endsWith('.scene.json'))
  .map((file) => ({ name: scene_name(file), title: parse(readFileSync(file, 'utf8')).name, file: relative(scenes, file), files: named_files(file), ...shown_with(file) }));
rmSync(join(site, 'scenes'), { recursive: true, force: true });
for (const file of new Set(list.flatMap((scene) => [scene.file, ...scene.files, scene.path, scene.picture].filter(Boolean)))) cpSync(join(scenes, file), join(site, 'scenes', file));
writeFileSync(join(site, 'scenes/list.json'), JSON.stringify(list));

const files = all_files(site)
  .map((file) => relative(site, file))
  .filter((file) => file !== 'offline.js');
const version = createHash('sha256');
for (const file of files) version.update(file).update(readFileSync(join(site, file)));
const template = readFileSync(new URL('offline.js', import.meta.url), 'utf8');
writeFileSync(
  join(site, 'offline.js'),
  template.replace('VERSION', version.digest('hex').slice(0, 12)).replace('FILES', JSON.stringify(['./', ...files])),
);
const kB = (names) => Math.round(names.reduce((sum, name) => sum + gzipSync(readFileSync(join(site, name)), { level: 9 }).length, 0) / 1000);
const first = files.filter((file) => !file.startsWith('scenes/'));
console.log(`${site}: ${files.length} files, ${kB(first)} kB compressed and ${kB(files) - kB(first)} kB of scenes`);
