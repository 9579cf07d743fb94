// Every scene under its own hands, and the logs of `thimble simulate`.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';

import { all_files, kScenes, kThimble } from './modules';

export interface Run {
  name: string;
  image: Uint8Array;
  path: Uint8Array; // rows of time, position and arm: 64-bit numbers
  log: string; // of `thimble simulate`
}

const kTrailer_bytes = 8; // "CRC1" and the CRC
const kDefault = join(kScenes, 'probe.csv');

// Whatever the order of the columns.
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

export function all_runs(): Run[] {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-site-'));
  const [image, log] = [join(folder, 'image'), join(folder, 'log.csv')];
  const runs = all_files(kScenes)
    .filter((file) => file.endsWith('.scene.json'))
    .flatMap((scene) => {
      execFileSync(kThimble, ['compile', scene, '--output', image], { stdio: 'ignore' });
      const bytes = readFileSync(image).subarray(0, -kTrailer_bytes);
      return hands(scene).map((hand) => {
        execFileSync(kThimble, ['simulate', image, '--path', hand, '--log', log], { stdio: 'ignore' });
        const path = new Uint8Array(read_path(hand).buffer);
        return { name: `${basename(scene)} by ${basename(hand)}`, image: bytes, path, log: readFileSync(log, 'utf8') };
      });
    });
  rmSync(folder, { recursive: true });
  return runs;
}
