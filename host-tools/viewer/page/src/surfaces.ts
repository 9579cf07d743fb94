// Where the surfaces of the scene are: the nearest point of one, and what a ray meets. Planes, and the flat tops of tissues and needles'
// ways, are computed; anything else is a hierarchy of boxes about the triangles that are drawn, built once a scene. An object that
// moves is asked in its own frame. Fields have no surface; a ray meets what is drawn of them only where `volumes` says so.
import { DoubleSide, Mesh, type Object3D, Ray, Vector3 } from 'three';
import { MeshBVH } from 'three-mesh-bvh';

import { type Dimple, surface_m } from './dimple';
import { kNeedleBlock_m } from './geometry';
import type { ObjectModel } from './scene_image';
import { type Quat, type Vec3, add, conjugate, cross, dot, length, rotate, scale, sub, unit } from './vector';

export interface Placed {
  model: ObjectModel;
  group: Object3D; // where it is now
  meshes: readonly Mesh[];
  dimples: readonly Dimple[]; // of a tissue
}

export interface SurfacePoint {
  object: number;
  point: Vec3;
  normal: Vec3; // out of the object
  distance_m: number; // below 0 inside; along a ray never
}

type Local = Omit<SurfacePoint, 'object'>;

interface Shape {
  volume: boolean;
  nearest(p: Vec3, within_m: number): Local | null;
  along(p: Vec3, direction: Vec3): Local | null;
}

export class Surfaces {
  private readonly shapes: (Shape | null)[];

  constructor(private readonly placed: readonly Placed[]) {
    this.shapes = placed.map(shape_of);
  }

  // Of one object, or of all.
  nearest(p: Vec3, only?: number): SurfacePoint | null {
    let found: SurfacePoint | null = null;
    this.shapes.forEach((shape, object) => {
      if (shape === null || (only === undefined ? shape.volume : object !== only)) return;
      const [position, rotation] = this.pose(object);
      const within_m = found === null ? Infinity : Math.abs(found.distance_m);
      const local = shape.nearest(rotate(conjugate(rotation), sub(p, position)), within_m);
      if (local === null || Math.abs(local.distance_m) >= within_m) return;
      found = in_world(local, object, position, rotation);
    });
    return found;
  }

  along(p: Vec3, direction: Vec3, volumes = false): SurfacePoint | null {
    let found: SurfacePoint | null = null;
    this.shapes.forEach((shape, object) => {
      if (shape === null || (shape.volume && !volumes)) return;
      const [position, rotation] = this.pose(object);
      const back = conjugate(rotation);
      const local = shape.along(rotate(back, sub(p, position)), rotate(back, direction));
      if (local === null || (found !== null && local.distance_m >= found.distance_m)) return;
      found = in_world(local, object, position, rotation);
    });
    return found;
  }

  below(p: Vec3): SurfacePoint | null {
    return this.along(p, [0, 0, -1]);
  }

  private pose(object: number): [Vec3, Quat] {
    const { position, quaternion: q } = this.placed[object].group;
    return [
      [position.x, position.y, position.z],
      [q.w, q.x, q.y, q.z],
    ];
  }
}

const in_world = ({ point, normal, distance_m }: Local, object: number, position: Vec3, rotation: Quat): SurfacePoint => ({
  object,
  point: add(position, rotate(rotation, point)),
  normal: rotate(rotation, normal),
  distance_m,
});

function shape_of(placed: Placed): Shape | null {
  const { shape } = placed.model;
  switch (shape.kind) {
    case 'plane':
      return plane_shape(shape.normal, shape.offset_m);
    case 'needle':
      return top_shape(kNeedleBlock_m / 2, kNeedleBlock_m / 2, () => 0);
    case 'tissue':
      return top_shape(shape.half_x_m, shape.half_y_m, (x, y) => surface_m(x, y, placed.dimples, shape.contact_radius_m));
    default:
      return mesh_shape(placed.meshes, kFields.has(shape.kind), both_sides(placed.model));
  }
}

const kFields = new Set(['vector_field', 'potential_field', 'force_field']);
const both_sides = ({ shape }: ObjectModel): boolean => shape.kind === 'mesh' && shape.two_sided;

function plane_shape(normal: Vec3, offset_m: number): Shape {
  const height = (p: Vec3) => dot(normal, p) - offset_m;
  return {
    volume: false,
    nearest: (p) => ({ point: sub(p, scale(normal, height(p))), normal, distance_m: height(p) }),
    along: (p, direction) => {
      const distance_m = -height(p) / dot(normal, direction);
      return dot(normal, direction) < 0 && distance_m >= 0 ? { point: add(p, scale(direction, distance_m)), normal, distance_m } : null;
    },
  };
}

// A flat top in the plane z = 0, which may be sunk by little.
function top_shape(half_x_m: number, half_y_m: number, z_m: (x: number, y: number) => number): Shape {
  const normal: Vec3 = [0, 0, 1];
  return {
    volume: false,
    nearest: (p) => {
      const x = Math.min(Math.max(p[0], -half_x_m), half_x_m);
      const y = Math.min(Math.max(p[1], -half_y_m), half_y_m);
      const point: Vec3 = [x, y, z_m(x, y)];
      const over = sub(p, point);
      return { point, normal, distance_m: over[2] < 0 ? -length(over) : length(over) };
    },
    along: (p, direction) => {
      if (direction[2] >= 0 || p[2] < z_m(p[0], p[1])) return null;
      const distance_m = p[2] / -direction[2];
      const [x, y] = add(p, scale(direction, distance_m));
      return Math.abs(x) > half_x_m || Math.abs(y) > half_y_m ? null : { point: [x, y, z_m(x, y)], normal, distance_m };
    },
  };
}

function mesh_shape(meshes: readonly Mesh[], volume: boolean, two_sided: boolean): Shape | null {
  const trees = meshes.filter(({ geometry }) => geometry.getAttribute('position').count > 0).map(({ geometry }) => tree_of(geometry));
  if (trees.length === 0) return null;
  return {
    volume,
    nearest: (p, within_m) => {
      let found: Local | null = null;
      for (const tree of trees) {
        const hit = tree.closestPointToPoint(
          new Vector3(...p),
          undefined,
          0,
          found === null ? within_m : Math.abs((found as Local).distance_m),
        );
        if (hit === null) continue;
        const point = hit.point.toArray() as Vec3;
        const normal = normal_of(tree, hit.faceIndex);
        const over = sub(p, point);
        const inside = !two_sided && dot(over, normal) < 0;
        const faces = two_sided && dot(over, normal) < 0 ? scale(normal, -1) : normal;
        found = { point, normal: faces, distance_m: inside ? -hit.distance : hit.distance };
      }
      return found;
    },
    along: (p, direction) => {
      let found: Local | null = null;
      for (const tree of trees) {
        const hit = tree.raycastFirst(new Ray(new Vector3(...p), new Vector3(...direction)), DoubleSide);
        if (hit === null || (found !== null && hit.distance >= (found as Local).distance_m)) continue;
        const normal = normal_of(tree, hit.faceIndex as number);
        const faces = dot(normal, direction) > 0 ? scale(normal, -1) : normal;
        found = { point: hit.point.toArray() as Vec3, normal: faces, distance_m: hit.distance };
      }
      return found;
    },
  };
}

// The order of the triangles is left to the geometry, which is drawn.
const tree_of = (geometry: Mesh['geometry']): MeshBVH => new MeshBVH(geometry, { indirect: true });

function normal_of({ geometry }: MeshBVH, face: number): Vec3 {
  const position = geometry.getAttribute('position');
  const [a, b, c] = [0, 1, 2].map((i): Vec3 => {
    const vertex = geometry.index ? geometry.index.getX(3 * face + i) : 3 * face + i;
    return [position.getX(vertex), position.getY(vertex), position.getZ(vertex)];
  });
  return unit(cross(sub(b, a), sub(c, a)));
}
