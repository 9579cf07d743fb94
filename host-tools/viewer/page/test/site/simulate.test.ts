// Every scene under its own hands: the log of the site's controller against `thimble simulate`, byte for byte.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { after, test } from 'node:test';

import { Module } from '../../src/in_page/module';
import { all_files, kModule, kScenes, kThimble } from './modules';

const folder = mkdtempSync(join(tmpdir(), 'thimble-site-'));
after(() => rmSync(folder, { recursive: true }));
const kTrailer_bytes = 8;
const kDefault = join(kScenes, 'probe.csv');

// Rows of time, position and arm, whatever the order of the columns.
function read_path(file: string): Float64Array {
  const [header, ...rows] = readFileSync(file, 'utf8')
    .trim()
    .split(/\r?\n/)
    .filter((line) => !line.startsWith('#'));
  const columns = header.split(',').map((name) => name.trim());
  const order = ['time_s', 'x_m', 'y_m', 'z_m', 'arm'].map((name) => columns.indexOf(name));
  return new Float64Array(rows.flatMap((row) => order.map((at) => (at < 0 ? 0 : Number(row.split(',')[at])))));
}

// As ./demo chooses it, and every other path beside the scene.
function hands(scene: string): string[] {
  const own = all_files(dirname(scene)).filter((file) => /(^|[/.])(stroke|hand|probe)\.csv$/.test(file));
  return own.length > 0 ? own : [kDefault];
}

const module = new Module(kModule);

for (const scene of all_files(kScenes).filter((file) => file.endsWith('.scene.json')))
  test(basename(scene), () => {
    const image = join(folder, 'image');
    execFileSync(kThimble, ['compile', scene, '--output', image], { stdio: 'ignore' });
    const bytes = readFileSync(image).subarray(0, -kTrailer_bytes);
    for (const hand of hands(scene)) {
      const path = read_path(hand);
      module.put(bytes, new Uint8Array(path.buffer));
      const log = module.given_text(module.call.simulate(bytes.length, 0, 4000));
      const native = join(folder, 'log.csv');
      execFileSync(kThimble, ['simulate', image, '--path', hand, '--log', native], { stdio: 'ignore' });
      assert.ok(log === readFileSync(native, 'utf8'), `${basename(hand)}: another log: ${log.slice(0, 300)}`);
    }
  });
