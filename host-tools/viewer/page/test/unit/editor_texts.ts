// Scenes as texts, for the tests of the editor: those of scenes/, and the same with comments at every place and with other formatting.
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';

import { createScanner } from 'jsonc-parser';

const kScenes = new URL('../../../../../scenes', import.meta.url).pathname;

const files = (folder: string): string[] =>
  readdirSync(folder)
    .sort()
    .map((name) => join(folder, name))
    .flatMap((file) => (statSync(file).isDirectory() ? files(file) : file.endsWith('.scene.json') ? [file] : []));

export const kSceneTexts = files(kScenes).map((file) => ({ name: file.slice(kScenes.length + 1), text: readFileSync(file, 'utf8') }));

// A numbered comment behind every token, in turn of each kind.
export function with_comments(text: string): string {
  const scanner = createScanner(text, false);
  let [out, number] = ['', 0];
  for (;;) {
    scanner.scan();
    const token = text.slice(scanner.getTokenOffset(), scanner.getTokenOffset() + scanner.getTokenLength());
    if (token === '') return out;
    out += token;
    if (token.trim() !== '') out += ++number % 5 === 0 ? ` // remark ${number}, "x": [}\n` : ` /* remark ${number} */`;
  }
}

export const remarks = (text: string): string[] => text.match(/remark \d+\b/g) ?? [];

// The value without comments, by a way of its own: not the parser that the editor uses.
export function value_of(text: string): Scene {
  const plain = text.replace(/("(?:\\.|[^"\\])*")|\/\/[^\n]*|\/\*[\s\S]*?\*\//g, (_all, quoted: string | undefined) => quoted ?? ' ');
  return JSON.parse(plain) as Scene;
}

export interface SceneObject {
  name: string;
  shape: Record<string, Record<string, unknown>>;
  material: string | Record<string, unknown>;
  pose?: { position_m?: number[]; rotation_deg?: number[] };
  body?: { pivot_m?: number[] };
}
export interface Scene {
  objects: SceneObject[];
  materials?: Record<string, Record<string, unknown>>;
}
