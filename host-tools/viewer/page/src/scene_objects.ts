// The objects of the running scene in the 3D view: geometry built once, then only moved. A tissue's surface is the exception: it
// sinks where it is pressed.
import {
  Box3,
  BufferAttribute,
  Color,
  DataTexture,
  DoubleSide,
  FrontSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  LinearFilter,
  LinearMipmapLinearFilter,
  Material,
  Mesh,
  MeshLambertMaterial,
  Quaternion,
  RedFormat,
  RepeatWrapping,
  Vector3,
} from 'three';

import { type Dimple, surface_m } from './dimple';
import { type Part, build_parts, of_lines, of_patch, of_stiffness_map } from './geometry';
import { is_wall, plane_patch } from './plane_patch';
import type { State } from './protocol';
import type { ObjectModel, SceneModel, StiffnessMapModel, TextureModel, TissueModel } from './scene_image';
import { type Placed, Surfaces } from './surfaces';
import { type Vec3, add, rotate } from './vector';

const kHues = [210, 28, 150, 330, 265, 75, 185, 0];
const kLineColor = 0x6b7684;
const kWall_m = 0.02; // that a wall is higher than what is in front of it
const kReliefPixel_m = 0.0003; // three.js reckons heights in pixels: about one where a scene is seen from
const kHalfMiddle_m = 0.05; // of the workspace, where nothing but planes says how large a scene is
const kHome_m = 0.015; // about the home of a tip
const kMoves_m = 0.01; // about what moves
const kRoom_m = 0.3; // across the floor of one
export const kHomes: Record<number, Vec3[]> = {
  1: [[0, 0, 0]],
  2: [
    [-0.1, 0, 0],
    [0.1, 0, 0],
  ],
};
const kSwitchedOn = new Color(0x2f9e44);

interface Shown extends Placed {
  group: Group;
  materials: MeshLambertMaterial[];
  dimples: Dimple[];
  tissue: { shape: TissueModel; mesh: Mesh; dimples: string } | null;
}

// Of all planes; it follows light and dark.
export function set_plane_color(color: string): void {
  kPlaneMaterial.color.set(color);
}

export class SceneObjects {
  readonly group = new Group();
  private shown: Shown[] = [];

  constructor(
    readonly model: SceneModel,
    arms: number,
  ) {
    model.objects.forEach((object, index) => {
      const it = show(object, index);
      this.shown.push(it);
      this.group.add(it.group);
    });
    this.surfaces = new Surfaces(this.shown);
    this.bounds = this.find_bounds(arms);
    const walls = { from_m: this.bounds.min.z, to_m: this.bounds.max.z };
    model.objects.forEach((object, index) => {
      if (object.shape.kind !== 'plane') return;
      const patch = plane_patch(model.objects, index, walls);
      const floor = new Mesh(of_patch(patch), kPlaneMaterial);
      floor.receiveShadow = true;
      this.shown[index].group.add(floor, new LineSegments(of_lines(patch), kGridMaterial));
      if (object.stiffness_map !== null) this.shown[index].group.add(colored(object.stiffness_map, index));
    });
  }

  readonly surfaces: Surfaces;

  // The box to show: the objects, and the homes of the tips. Planes are infinite and do not count.
  readonly bounds: Box3;

  private find_bounds(arms: number): Box3 {
    const box = new Box3();
    for (const home of kHomes[arms] ?? []) box.expandByPoint(new Vector3(...home));
    box.expandByScalar(kHome_m);
    this.group.updateMatrixWorld(true);
    for (const { model, group } of this.shown) {
      if (model.shape.kind === 'plane') continue;
      const own = new Box3().setFromObject(group);
      box.union(model.moves ? own.expandByScalar(kMoves_m) : own);
    }
    const planes = this.model.objects.flatMap(({ shape }, index) => (shape.kind === 'plane' ? [index] : []));
    if (planes.length === this.shown.length) {
      box.expandByPoint(new Vector3(-kHalfMiddle_m, -kHalfMiddle_m, -kHalfMiddle_m));
      box.expandByPoint(new Vector3(kHalfMiddle_m, kHalfMiddle_m, kHome_m));
    }
    for (const index of planes) {
      const { shape, rotation, position_m } = this.model.objects[index];
      if (shape.kind !== 'plane') continue;
      if (is_wall(rotate(rotation, shape.normal))) {
        box.max.z = Math.max(box.max.z, kHome_m + kWall_m);
        continue;
      }
      // The floor of a room.
      const corners = plane_patch(this.model.objects, index, { from_m: 0, to_m: 0 }).corners;
      const floor = new Box3().setFromPoints(corners.map((corner) => new Vector3(...add(position_m, rotate(rotation, corner)))));
      if (floor.getSize(new Vector3()).length() < kRoom_m) box.union(floor);
    }
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
      if (it.tissue !== null) sink(it.tissue, (it.dimples = dimples_of(state, index)));
    });
  }

  dispose(): void {
    this.group.removeFromParent();
    this.group.traverse((it) => {
      if (!(it instanceof Mesh) && !(it instanceof LineSegments)) return;
      it.geometry.dispose();
      for (const material of [it.material].flat() as Material[]) {
        if (material instanceof MeshLambertMaterial) material.bumpMap?.dispose();
        if (material !== kGridMaterial && material !== kPlaneMaterial) material.dispose();
      }
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
  const materials = parts.map((part) => material_of(part, index, model));
  const meshes = parts.map((part, i) => {
    const mesh = new Mesh(part.geometry, materials[i]);
    group.add(mesh);
    mesh.castShadow = mesh.receiveShadow = !part.see_through;
    return mesh;
  });
  const it: Shown = {
    model,
    group,
    meshes,
    materials,
    dimples: [],
    tissue: model.shape.kind === 'tissue' ? { shape: model.shape, mesh: meshes[0], dimples: '' } : null,
  };
  place_at_start(it);
  return it;
}

function material_of(part: Part, index: number, { shape, texture }: ObjectModel): MeshLambertMaterial {
  return new MeshLambertMaterial({
    ...(texture !== null && shape.kind === 'box' ? relief(texture) : {}),
    color: object_color(index, part.shade),
    flatShading: part.faceted,
    side: part.two_sided ? DoubleSide : FrontSide,
    transparent: part.see_through,
    opacity: part.see_through ? 0.45 : 1,
    depthWrite: !part.see_through,
    fog: false,
  });
}

// A texture is drawn by its normals, those of its heights; the outline is the shape's.
function relief(texture: TextureModel): { bumpMap: DataTexture; bumpScale: number } {
  const least = texture.height_m.reduce((a, b) => Math.min(a, b), Infinity);
  const most = texture.height_m.reduce((a, b) => Math.max(a, b), -Infinity);
  const steps = Uint8Array.from(texture.height_m, (height) => Math.round((255 * (height - least)) / (most - least || 1)));
  const map = new DataTexture(steps, texture.columns, texture.rows, RedFormat);
  map.wrapS = map.wrapT = RepeatWrapping;
  map.magFilter = LinearFilter;
  map.minFilter = LinearMipmapLinearFilter;
  map.generateMipmaps = true;
  map.unpackAlignment = 1;
  map.repeat.set(1 / texture.tile_m[0], 1 / texture.tile_m[1]);
  map.needsUpdate = true;
  return { bumpMap: map, bumpScale: (most - least) / kReliefPixel_m };
}

const object_color = (index: number, shade: number): Color =>
  new Color().setHSL(kHues[index % kHues.length] / 360, 0.55, 0.6 - 0.28 * shade);

// Its grid, its colours, and objects that stand on it are seen rather than the plane.
const kPlaneMaterial = new MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
const kGridMaterial = new LineBasicMaterial({ color: kLineColor, transparent: true, opacity: 0.4 });

// Stiffer parts are darker.
function colored(map: StiffnessMapModel, index: number): Mesh {
  const geometry = of_stiffness_map(map, (share) => object_color(index, 0.2 + 1.2 * share).toArray() as [number, number, number]);
  const mesh = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, fog: false }));
  mesh.receiveShadow = true;
  return mesh;
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
