// What the editor does to a scene, as edits of its text.
import { findNodeAtLocation } from 'jsonc-parser';

import { type Vec3, add as add_up, sub } from '../vector';
import {
  type Edit,
  type Json,
  NotJson,
  apply,
  insert_element,
  print_lines,
  remove_element,
  rename_key,
  set_value,
  tree_of,
} from './json_edits';
import { type Outline, type OutlinedObject, outline_of } from './scene_outline';

const kDuplicateAside_m = 0.02;

// A number as people write it.
export const rounded = (value: number): number => Number(value.toPrecision(7)) + 0;
// To the micrometre, or a thousandth of a degree; what has not changed stays as it is.
const changed = (now: Vec3, to: Vec3, digits: number): number[] =>
  to.map((value, i) => (value === now[i] ? value : Number(value.toFixed(digits)) + 0));
const kMicrometres = 6;
const kThousandths = 3;

export function outline(text: string): Outline {
  const found = outline_of(text);
  if (found === null) throw new NotJson('the text has no objects');
  return found;
}

function object_of(text: string, index: number): OutlinedObject {
  const object = outline(text).objects[index];
  if (object === undefined) throw new NotJson(`the text has no object ${index}`);
  return object;
}

// --- Pose and size

// The axis of what turns goes along.
export function move(text: string, index: number, position_m: Vec3): Edit[] {
  const object = object_of(text, index);
  const edits = unless_same(object.position_m, changed(object.position_m, position_m, kMicrometres), (to) =>
    set_value(text, ['objects', index, 'pose', 'position_m'], to),
  );
  if (object.pivot_m === null || edits.length === 0) return edits;
  const pivot_m = add_up(object.pivot_m, sub(position_m, object.position_m));
  return [...edits, ...set_value(text, ['objects', index, 'body', 'pivot_m'], changed(object.pivot_m, pivot_m, kMicrometres))];
}

export function turn(text: string, index: number, rotation_deg: Vec3): Edit[] {
  const now = object_of(text, index).rotation_deg;
  return unless_same(now, changed(now, rotation_deg, kThousandths), (to) =>
    set_value(text, ['objects', index, 'pose', 'rotation_deg'], to),
  );
}

function unless_same(now: readonly number[], to: number[], edits: (to: number[]) => Edit[]): Edit[] {
  return now.every((value, i) => value === to[i]) ? [] : edits(to);
}

export function resize(text: string, index: number, size: number, value: number): Edit[] {
  const { sizes } = object_of(text, index);
  return sizes[size] === undefined || sizes[size].value === value
    ? []
    : set_value(text, ['objects', index, ...sizes[size].path], rounded(value));
}

// By factors along the axes of its frame. What grows along several of them grows by the factor that is farthest from 1.
export function scale(text: string, index: number, factors: Vec3): Edit[] {
  const { sizes } = object_of(text, index);
  return sizes.flatMap((size) => {
    const factor = size.axes.map((axis) => factors[axis]).sort((a, b) => Math.abs(Math.log(b)) - Math.abs(Math.log(a)))[0];
    if (factor === undefined || factor === 1) return [];
    return set_value(text, ['objects', index, ...size.path], rounded(size.value * factor));
  });
}

// --- Objects

export function free_name(text: string, wanted: string): string {
  const taken = new Set(outline(text).objects.map((object) => object.name));
  if (!taken.has(wanted)) return wanted;
  const stem = wanted.replace(/ \d+$/, '');
  let number = 2;
  while (taken.has(`${stem} ${number}`)) ++number;
  return `${stem} ${number}`;
}

export const rename = (text: string, index: number, name: string): Edit[] => set_value(text, ['objects', index, 'name'], name);

export function duplicate(text: string, index: number): Edit[] {
  const object = object_of(text, index);
  const own = `{"objects": [${text.slice(object.offset, object.end)}]}`;
  const named = apply(own, rename(own, 0, free_name(text, object.name)));
  const [x, y, z] = object.position_m;
  const moved = apply(named, move(named, 0, [x + kDuplicateAside_m, y, z]));
  const copy = object_of(moved, 0);
  return insert_element(text, ['objects'], moved.slice(copy.offset, copy.end), index);
}

export const remove = (text: string, index: number): Edit[] => remove_element(text, ['objects'], index);

export const add = (text: string, object: { [key: string]: Json }): Edit[] =>
  insert_element(text, ['objects'], print_lines({ ...object, name: free_name(text, String(object.name)) }, '    '));

// --- Materials

const material_path = (object: OutlinedObject): (string | number)[] =>
  object.material === null ? ['objects', object.index, 'material'] : ['materials', object.material];

export const material_value = (text: string, index: number, key: string): Json | undefined => {
  const object = object_of(text, index);
  return findNodeAtLocation(tree_of(text), [...material_path(object), key])?.value as Json | undefined;
};

// Of all objects that share the material.
export const set_material = (text: string, index: number, key: string, value: number): Edit[] =>
  set_value(text, [...material_path(object_of(text, index)), key], rounded(value));

export const assign_material = (text: string, index: number, name: string): Edit[] => set_value(text, ['objects', index, 'material'], name);

// Its own material gets a name, so that others can share it.
export function name_material(text: string, index: number, name: string): Edit[] {
  const object = object_of(text, index);
  if (object.material !== null) return rename_material(text, object.material, name);
  const node = findNodeAtLocation(tree_of(text), ['objects', index, 'material']);
  if (node === undefined) throw new NotJson('the object has no material');
  const own = text.slice(node.offset, node.offset + node.length);
  const assigned: Edit = { offset: node.offset, length: node.length, content: JSON.stringify(name) };
  const listed = set_value(text, ['materials', name], {});
  return [assigned, ...listed.map((edit) => ({ ...edit, content: with_last_braces(edit.content, own) }))];
}

// The text of a new member "name": {} with its value written as it was elsewhere.
function with_last_braces(content: string, value: string): string {
  const at = content.lastIndexOf('{}');
  return at < 0 ? content : content.slice(0, at) + value + content.slice(at + 2);
}

export function rename_material(text: string, from: string, to: string): Edit[] {
  const found = outline(text).materials.find((material) => material.name === from);
  if (found === undefined || from === to) return [];
  return [...rename_key(text, ['materials', from], to), ...found.users.flatMap((user) => assign_material(text, user, to))];
}

// A copy that no other object shares.
export function own_material(text: string, index: number): Edit[] {
  const object = object_of(text, index);
  if (object.material === null) return [];
  const root = tree_of(text);
  const shared = findNodeAtLocation(root, ['materials', object.material]);
  const name = findNodeAtLocation(root, ['objects', index, 'material']);
  if (shared === undefined || name === undefined) return [];
  return [{ offset: name.offset, length: name.length, content: text.slice(shared.offset, shared.offset + shared.length) }];
}

// --- Changes as one edit

// The one edit that makes a text of another: what both begin and end with stays.
export function whole(from: string, to: string): Edit[] {
  if (from === to) return [];
  let begin = 0;
  while (begin < from.length && from[begin] === to[begin]) ++begin;
  let end = 0;
  while (end < Math.min(from.length, to.length) - begin && from[from.length - 1 - end] === to[to.length - 1 - end]) ++end;
  return [{ offset: begin, length: from.length - end - begin, content: to.slice(begin, to.length - end) }];
}
