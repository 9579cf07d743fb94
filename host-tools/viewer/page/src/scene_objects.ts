// The objects of the running scene in the 3D view: geometry built once, then only moved. A tissue's surface is the exception: it
// sinks where it is pressed.
import {
  Box3,
  BufferAttribute,
  Color,
  DoubleSide,
  FrontSide,
  GridHelper,
  Group,
  Material,
  Mesh,
  MeshLambertMaterial,
  Quaternion,
  Vector3,
} from 'three';

import { type Dimple, surface_m } from './dimple';
import { type Part, build_parts, kPlaneSize_m } from './geometry';
import type { State } from './protocol';
import type { ObjectModel, SceneModel, TissueModel } from './scene_image';

const kHues = [210, 28, 150, 330, 265, 75, 185, 0];
const kSwitchedOn = new Color(0x2f9e44);

interface Shown {
  model: ObjectModel;
  group: Group;
  materials: MeshLambertMaterial[];
  tissue: { shape: TissueModel; mesh: Mesh; dimples: string } | null;
}

export class SceneObjects {
  readonly group = new Group();
  private shown: Shown[] = [];

  constructor(readonly model: SceneModel) {
    model.objects.forEach((object, index) => {
      const it = show(object, index);
      this.shown.push(it);
      this.group.add(it.group);
    });
  }

  // What there is to look at: the middle of the workspace, where two tips stand side by side, and the objects. Planes have no end and say
  // nothing.
  bounds(arms: number): Box3 {
    const half_x_m = arms > 1 ? 0.1 : 0.05;
    const box = new Box3(new Vector3(-half_x_m, -0.05, -0.05), new Vector3(half_x_m, 0.05, 0.05));
    for (const { model, group } of this.shown) if (model.shape.kind !== 'plane') box.expandByObject(group);
    return box;
  }

  update(state: State): void {
    for (const control of state.controls ?? []) this.place_control(control.object, control.q, control.on);
    for (const body of state.bodies ?? []) {
      const it = this.shown[body.object];
      if (it === undefined) continue;
      const [w, x, y, z] = body.rotation;
      it.group.position.set(...body.position_m);
      it.group.quaternion.set(x, y, z, w);
    }
    this.shown.forEach((it, index) => {
      if (it.tissue !== null) sink(it.tissue, dimples_of(state, index));
    });
  }

  dispose(): void {
    this.group.removeFromParent();
    this.group.traverse((it) => {
      if (!(it instanceof Mesh) && !(it instanceof GridHelper)) return;
      it.geometry.dispose();
      for (const material of [it.material].flat() as Material[]) material.dispose();
    });
  }

  private place_control(index: number, q: number, on: boolean): void {
    const it = this.shown[index];
    if (it === undefined || it.model.control === null) return;
    const { turns, axis, pivot_m } = it.model.control;
    const direction = new Vector3(...axis);
    place_at_start(it);
    if (turns) {
      const turn = new Quaternion().setFromAxisAngle(direction, q);
      const pivot = new Vector3(...pivot_m);
      it.group.position.sub(pivot).applyQuaternion(turn).add(pivot);
      it.group.quaternion.premultiply(turn);
    } else {
      it.group.position.addScaledVector(direction, q);
    }
    for (const material of it.materials) material.emissive.copy(on ? kSwitchedOn : kOff);
  }
}

const kOff = new Color(0);

function place_at_start({ model, group }: Pick<Shown, 'model' | 'group'>): void {
  const [w, x, y, z] = model.rotation;
  group.position.set(...model.position_m);
  group.quaternion.set(x, y, z, w);
}

function show(model: ObjectModel, index: number): Shown {
  const group = new Group();
  group.name = model.name;
  const parts = build_parts(model.shape);
  const materials = parts.map((part) => material_of(part, index));
  const meshes = parts.map((part, i) => {
    const mesh = new Mesh(part.geometry, materials[i]);
    group.add(mesh);
    if (part.grid) mesh.add(grid_on(model));
    return mesh;
  });
  const it: Shown = {
    model,
    group,
    materials,
    tissue: model.shape.kind === 'tissue' ? { shape: model.shape, mesh: meshes[0], dimples: '' } : null,
  };
  place_at_start(it);
  return it;
}

function material_of(part: Part, index: number): MeshLambertMaterial {
  const color = part.grid ? new Color(0xb4bac4) : new Color().setHSL(kHues[index % kHues.length] / 360, 0.45, 0.64 - 0.3 * part.shade);
  return new MeshLambertMaterial({
    color,
    flatShading: part.faceted,
    side: part.two_sided ? DoubleSide : FrontSide,
    transparent: part.see_through,
    opacity: part.see_through ? 0.45 : 1,
    depthWrite: !part.see_through,
    // The grid of a plane, and objects that stand on one, are seen rather than the plane.
    polygonOffset: part.grid,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
}

// Lines 2 cm apart on the free side of a plane.
function grid_on(model: ObjectModel): Group {
  const holder = new Group();
  if (model.shape.kind !== 'plane') return holder;
  const normal = new Vector3(...model.shape.normal);
  const grid = new GridHelper(kPlaneSize_m, 20, 0x6b7280, 0x6b7280);
  grid.material.transparent = true;
  grid.material.opacity = 0.35;
  grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), normal);
  grid.position.copy(normal).multiplyScalar(model.shape.offset_m + 0.0001);
  holder.add(grid);
  return holder;
}

const dimples_of = (state: State, object: number): Dimple[] =>
  (state.tissues ?? [])
    .filter((it) => it.object === object && it.depth_m > 0)
    .map((it) => ({ x_m: it.at_m[0], y_m: it.at_m[1], depth_m: it.depth_m }));

function sink(tissue: NonNullable<Shown['tissue']>, dimples: Dimple[]): void {
  const key = JSON.stringify(dimples);
  if (key === tissue.dimples) return;
  tissue.dimples = key;
  const positions = tissue.mesh.geometry.getAttribute('position') as BufferAttribute;
  for (let i = 0; i < positions.count; ++i)
    positions.setZ(i, surface_m(positions.getX(i), positions.getY(i), dimples, tissue.shape.contact_radius_m));
  positions.needsUpdate = true;
  tissue.mesh.geometry.computeVertexNormals();
}
