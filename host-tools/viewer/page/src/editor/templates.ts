// What can be added to a scene, below the tip's home. Control elements are those of scenes/buttons.
import type { Json } from './json_edits';
import type { Outline } from './scene_outline';

type Part = { [key: string]: Json };

const kStiff: Part = { stiffness_N_m: 800, damping_N_s_m: 1, static_friction: 0.4, dynamic_friction: 0.3 };

const solid = (name: string, shape: Part, height_m: number): Part => ({
  name,
  shape: { [name]: shape },
  pose: { position_m: [0, 0, Number((-0.02 - height_m / 2).toFixed(6))] },
});

const control = (name: string, shape: Part, position_m: number[], motion: string, axis: number[], mass_kg: number, how: Part): Part => ({
  name,
  shape,
  pose: { position_m },
  body: { motion, mass_kg, axis, control: how },
});

const kParts: Part[] = [
  solid('sphere', { radius_m: 0.02 }, 0.04),
  solid('box', { size_m: [0.04, 0.04, 0.02] }, 0.02),
  solid('cylinder', { radius_m: 0.015, height_m: 0.03 }, 0.03),
  solid('capsule', { radius_m: 0.01, height_m: 0.03 }, 0.05),
  solid('cone', { radius_m: 0.02, height_m: 0.03 }, 0.045),
  { name: 'plane', shape: { plane: { normal: [0, 0, 1], offset_m: -0.05 } } },
  control('button', { cylinder: { radius_m: 0.009, height_m: 0.01 } }, [0, 0, -0.036], 'slide', [0, 0, -1], 0.02, {
    damping_N_s_m: 0.5,
    low_m: 0,
    high_m: 0.0035,
    curve_m_N: [
      [0, 0.3],
      [0.0015, 2],
      [0.0022, 0.8],
      [0.0035, 1.6],
    ],
    switch: { on_at_m: 0.002, off_at_m: 0.001 },
  }),
  control('knob', { box: { size_m: [0.044, 0.008, 0.014] } }, [0, 0, -0.035], 'turn', [0, 0, 1], 0.04, {
    damping_N_m_s_rad: 0.0005,
    friction_N_m: 0.001,
    detents: { pitch_deg: 15, torque_N_m: 0.015 },
  }),
  control('slider', { box: { size_m: [0.01, 0.02, 0.014] } }, [0, 0, -0.035], 'slide', [1, 0, 0], 0.03, {
    damping_N_s_m: 0.5,
    friction_N: 0.2,
    low_m: -0.02,
    high_m: 0.02,
    detents: { pitch_m: 0.005, force_N: 0.8 },
  }),
  {
    name: 'toggle switch',
    shape: { capsule: { radius_m: 0.004, height_m: 0.02 } },
    pose: { position_m: [-0.004104, 0, -0.027724], rotation_deg: [0, -20, 0] },
    body: {
      motion: 'turn',
      mass_kg: 0.03,
      axis: [0, 1, 0],
      pivot_m: [0, 0, -0.039],
      control: {
        damping_N_m_s_rad: 0.0005,
        low_deg: 0,
        high_deg: 40,
        curve_deg_N_m: [
          [0, 0.01],
          [8, 0.025],
          [20, 0],
          [32, -0.025],
          [40, -0.01],
        ],
        switch: { on_at_deg: 28, off_at_deg: 12 },
      },
    },
  },
];

export const kAddable: readonly string[] = kParts.map((part) => String(part.name));

// Of the first material that the scene shares, if it has one.
const with_material = (part: Part, outline: Outline | null): Part => ({ ...part, material: outline?.materials[0]?.name ?? kStiff });

export function object_to_add(name: string, outline: Outline | null): Part {
  const part = kParts.find((one) => one.name === name);
  if (part === undefined) throw new Error(`nothing that can be added is called ${name}`);
  return with_material(part, outline);
}

const kMeshes = new Set(['obj', 'stl', 'ply', 'off', 'gltf', 'glb', 'plg', 'dae', 'fbx', '3ds']);
const kHeightsOf_m: Record<string, number> = { png: 0.01, csv: 0.001 }; // white; a unit of the values, which are millimetres as a rule

const ending_of = (file: string): string => file.slice(file.lastIndexOf('.') + 1).toLowerCase();

// The object of a file; null: files of objects name it.
export function object_of_file(file: string, outline: Outline | null): Part | null {
  const ending = ending_of(file);
  const name = file.slice(0, -ending.length - 1).slice(0, 60) || file;
  if (kMeshes.has(ending))
    return with_material({ name, shape: { mesh: { file, scale: 0.001 } }, pose: { position_m: [0, 0, 0] } }, outline);
  const height_m = kHeightsOf_m[ending];
  if (height_m === undefined) return null;
  const shape = { height_field: { file, size_m: [0.1, 0.1], height_m } };
  return with_material({ name, shape, pose: { position_m: [0, 0, -0.04] } }, outline);
}

export const is_scene_file = (file: string): boolean => file.toLowerCase().endsWith('.json');
export const is_mesh_file = (file: string): boolean => kMeshes.has(ending_of(file));
