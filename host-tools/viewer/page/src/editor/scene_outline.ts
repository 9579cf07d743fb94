// What the text of a scene says, as far as the editor shows it in fields. Values that are missing have their defaults; what is wrong is for the
// compiler to tell.
import { type Json, type JSONPath, type Node, tree_of } from './json_edits';
import { findNodeAtLocation, getNodeValue } from 'jsonc-parser';

import type { Vec3 } from '../vector';

// A length of a shape, or its scale.
export interface Size {
  label: string;
  path: JSONPath; // below the object
  value: number;
  axes: readonly number[]; // of the object's frame, along which it grows with it
}

export interface OutlinedObject {
  index: number;
  name: string;
  kind: string; // of its shape: "sphere"
  offset: number; // in the text
  end: number;
  position_m: Vec3;
  rotation_deg: Vec3;
  sizes: Size[];
  material: string | null; // the name of one of the scene's; null: its own
  pivot_m: Vec3 | null;
}

export interface OutlinedMaterial {
  name: string;
  users: number[]; // objects
}

export interface Outline {
  objects: OutlinedObject[];
  materials: OutlinedMaterial[];
}

const kZero: Vec3 = [0, 0, 0];

const is_number = (value: unknown): value is number => typeof value === 'number' && Number.isFinite(value);
const numbers = (value: unknown, count: number): number[] | null =>
  Array.isArray(value) && value.length === count && value.every(is_number) ? value : null;
const members = (value: unknown): Record<string, unknown> =>
  typeof value === 'object' && value !== null && !Array.isArray(value) ? (value as Record<string, unknown>) : {};

// Null where the text is no JSON object with objects.
export function outline_of(text: string): Outline | null {
  let root: Node;
  try {
    root = tree_of(text);
  } catch {
    return null;
  }
  const list = findNodeAtLocation(root, ['objects']);
  if (list?.type !== 'array') return null;
  const objects = (list.children ?? []).map(read_object);
  const names = Object.keys(members(value_at(root, ['materials'])));
  return {
    objects,
    materials: names.map((name) => ({
      name,
      users: objects.filter((object) => object.material === name).map((object) => object.index),
    })),
  };
}

export function value_at(root: Node, path: JSONPath): Json | undefined {
  const node = findNodeAtLocation(root, path);
  return node === undefined ? undefined : (getNodeValue(node) as Json);
}

function read_object(node: Node, index: number): OutlinedObject {
  const value = members(getNodeValue(node));
  const shape = members(value.shape);
  const kind = Object.keys(shape)[0] ?? '';
  const pose = members(value.pose);
  const body = members(value.body);
  return {
    index,
    name: typeof value.name === 'string' ? value.name : '',
    kind,
    offset: node.offset,
    end: node.offset + node.length,
    position_m: (numbers(pose.position_m, 3) as Vec3 | null) ?? kZero,
    rotation_deg: (numbers(pose.rotation_deg, 3) as Vec3 | null) ?? kZero,
    sizes: sizes_of(kind, members(shape[kind])),
    material: typeof value.material === 'string' ? value.material : null,
    pivot_m: numbers(body.pivot_m, 3) as Vec3 | null,
  };
}

const kAll = [0, 1, 2];

function sizes_of(kind: string, shape: Record<string, unknown>): Size[] {
  const one = (key: string, label: string, axes: readonly number[], usual?: number): Size[] => {
    const value = shape[key] ?? usual;
    return is_number(value) ? [{ label, path: ['shape', kind, key], value, axes }] : [];
  };
  const each = (key: string, count: number): Size[] =>
    (numbers(shape[key], count) ?? []).map((value, i) => ({
      label: `Size ${'xyz'[i]}, mm`,
      path: ['shape', kind, key, i],
      value,
      axes: [i],
    }));
  switch (kind) {
    case 'sphere':
      return one('radius_m', 'Radius, mm', kAll);
    case 'box':
      return each('size_m', 3);
    case 'cylinder':
    case 'capsule':
    case 'cone':
      return [...one('radius_m', 'Radius, mm', [0, 1]), ...one('height_m', 'Height, mm', [2])];
    case 'mesh':
      return one('scale', 'Scale, mm per unit', kAll, 1);
    case 'height_field':
      return [...each('size_m', 2), ...one('height_m', 'Height, mm per unit', [2])];
    case 'plane':
      return one('offset_m', 'Offset, mm', [], 0);
    default:
      return [];
  }
}
