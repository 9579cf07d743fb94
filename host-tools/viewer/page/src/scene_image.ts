// The scene image of /scene.thim as plain data, in metres and in each object's own frame, without graphics.
// Throws an Error with the reason if the bytes are not a scene image.
import { ByteBuffer } from 'flatbuffers';

import {
  Box,
  Capsule,
  Cone,
  Cylinder,
  ForceField,
  Mesh,
  Motion,
  Needle,
  Plane,
  PotentialField,
  Scene,
  Shape,
  Sphere,
  Tissue,
  Triangle,
  Vec3 as Position,
  VectorField,
  Vertex,
} from './generated/scene_generated';
import { TriangleFlag } from './generated/thimble/scene/triangle-flag';
import { decode_octahedral } from './octahedral';
import type { Material } from './protocol';
import type { Quat, Vec3 } from './vector';

export interface HalfSpaceModel {
  normal: Vec3;
  offset_m: number;
}
export interface SubvolumeModel {
  sides: HalfSpaceModel[];
  plane: HalfSpaceModel;
  centre_m: Vec3;
  radius_m: number; // 0: the plane pushes
}
export interface LayerModel {
  thickness_m: number;
  stiffness_N_m: number;
}

export interface MeshModel {
  kind: 'mesh';
  positions: Float32Array; // three numbers a vertex
  normals: Float32Array | null; // as many; null: faceted
  indices: Uint32Array; // three vertices a triangle
  two_sided: boolean;
}
export interface PotentialModel {
  kind: 'potential_field';
  count: Vec3;
  origin_m: Vec3;
  step_m: number;
  coefficients: Float32Array;
}
export type TissueModel = { kind: 'tissue'; half_x_m: number; half_y_m: number; contact_radius_m: number };

export type ShapeModel =
  | { kind: 'plane'; normal: Vec3; offset_m: number }
  | { kind: 'sphere'; radius_m: number }
  | { kind: 'box'; half_size_m: Vec3 }
  | { kind: 'cylinder' | 'capsule'; radius_m: number; half_height_m: number }
  | { kind: 'cone'; radius_m: number; height_m: number }
  | MeshModel
  | { kind: 'vector_field'; subvolumes: SubvolumeModel[]; lo_m: Vec3; hi_m: Vec3 }
  | PotentialModel
  | { kind: 'needle'; layers: LayerModel[] }
  | TissueModel
  | { kind: 'force_field'; half_size_m: Vec3 };

export interface ControlAxis {
  turns: boolean; // q is an angle about the axis through the pivot; else a way along the axis
  axis: Vec3;
  pivot_m: Vec3;
}

// Control points of a bicubic B-spline, u fastest, in the object's frame.
export interface StiffnessMapModel {
  columns: number;
  rows: number;
  cell_m: number;
  origin_m: Vec3;
  u: Vec3;
  v: Vec3;
  stiffness_N_m: Float32Array;
}

// One tile, u fastest; it repeats.
export interface TextureModel {
  columns: number;
  rows: number;
  tile_m: readonly [number, number];
  height_m: Float32Array; // control points, near the heights themselves
}

export interface ObjectModel {
  name: string;
  shape: ShapeModel;
  texture: TextureModel | null;
  stiffness_map: StiffnessMapModel | null;
  position_m: Vec3;
  rotation: Quat;
  material: Material;
  moves: boolean;
  control: ControlAxis | null;
}

export interface SceneModel {
  name: string;
  tip_radius_m: number; // 0: the tip is a point
  objects: ObjectModel[];
  triangles: number;
}

// Objects that the loops over a mesh reuse.
const kTriangle = new Triangle();
const kVertexBits = 0xfffff;
const kVertex = new Vertex();
const kPosition = new Position();

type XYZ = { x(): number; y(): number; z(): number } | null;
const vec3 = (v: XYZ): Vec3 => (v === null ? [0, 0, 0] : [v.x(), v.y(), v.z()]);

// The value of a required field; without it the image is broken.
function required<T>(value: T | null, what: string): T {
  if (value === null) throw new Error(`the scene image has no ${what}`);
  return value;
}

export function read_scene_image(bytes: Uint8Array): SceneModel {
  // Arrays of floats are read in place, which wants their alignment.
  const buffer = new ByteBuffer(bytes.byteOffset % 4 === 0 ? bytes : bytes.slice());
  if (bytes.length < 8 || !Scene.bufferHasIdentifier(buffer)) throw new Error('these bytes are no scene image');
  try {
    const scene = Scene.getRootAsScene(buffer);
    const objects = Array.from({ length: scene.objectsLength() }, (_, i) => read_object(scene, i));
    const triangles = objects.reduce((sum, object) => sum + triangles_of(object.shape), 0);
    return { name: scene.name() ?? '', tip_radius_m: scene.tipRadiusM(), objects, triangles };
  } catch (error) {
    if (error instanceof RangeError) throw new Error('the scene image is cut short or damaged');
    throw error;
  }
}

const triangles_of = (shape: ShapeModel): number => (shape.kind === 'mesh' ? shape.indices.length / 3 : 0);

function read_object(scene: Scene, index: number): ObjectModel {
  const object = required(scene.objects(index), 'object');
  const pose = required(object.pose(), 'pose');
  const rotation = required(pose.rotation(), 'rotation');
  const material = required(object.material(), 'material');
  const body = object.body();
  return {
    name: object.name() ?? '',
    shape: read_shape(object),
    texture: read_texture(object),
    stiffness_map: read_stiffness_map(object),
    position_m: vec3(pose.positionM()),
    rotation: [rotation.w(), rotation.x(), rotation.y(), rotation.z()],
    material: {
      stiffness: material.stiffnessNPerM(),
      damping: material.dampingNSPerM(),
      static_friction: material.staticFriction(),
      dynamic_friction: material.dynamicFriction(),
    },
    moves: body !== null,
    control:
      body === null || body.control() === null
        ? null
        : { turns: body.motion() === Motion.Turn, axis: vec3(body.axis()), pivot_m: vec3(body.pivotM()) },
  };
}

function read_texture(object: NonNullable<ReturnType<Scene['objects']>>): TextureModel | null {
  const texture = object.surface()?.texture();
  if (!texture) return null;
  const [columns, rows] = [texture.columns(), texture.rows()];
  const height_m = required(texture.heightMArray(), 'height');
  if (height_m.length !== columns * rows) throw new Error('a texture has too few heights');
  return { columns, rows, tile_m: [texture.tileUM(), texture.tileVM()], height_m };
}

function read_stiffness_map(object: NonNullable<ReturnType<Scene['objects']>>): StiffnessMapModel | null {
  const map = object.surface()?.stiffnessMap();
  if (!map) return null;
  const [columns, rows] = [map.columns(), map.rows()];
  const stiffness_N_m = required(map.stiffnessNPerMArray(), 'stiffness');
  if (stiffness_N_m.length !== columns * rows) throw new Error('a stiffness map has too few control points');
  const [origin_m, u, v] = [vec3(map.originM()), vec3(map.u()), vec3(map.v())];
  return { columns, rows, cell_m: map.cellM(), origin_m, u, v, stiffness_N_m };
}

function read_shape(object: NonNullable<ReturnType<Scene['objects']>>): ShapeModel {
  const as = <T>(shape: T): T => required(object.shape(shape) as T | null, 'shape');
  switch (object.shapeType()) {
    case Shape.Plane: {
      const plane = as(new Plane());
      return { kind: 'plane', normal: vec3(plane.normal()), offset_m: plane.offsetM() };
    }
    case Shape.Sphere:
      return { kind: 'sphere', radius_m: as(new Sphere()).radiusM() };
    case Shape.Box:
      return { kind: 'box', half_size_m: vec3(as(new Box()).halfSizeM()) };
    case Shape.Cylinder: {
      const cylinder = as(new Cylinder());
      return { kind: 'cylinder', radius_m: cylinder.radiusM(), half_height_m: cylinder.halfHeightM() };
    }
    case Shape.Capsule: {
      const capsule = as(new Capsule());
      return { kind: 'capsule', radius_m: capsule.radiusM(), half_height_m: capsule.halfHeightM() };
    }
    case Shape.Cone: {
      const cone = as(new Cone());
      return { kind: 'cone', radius_m: cone.radiusM(), height_m: cone.heightM() };
    }
    case Shape.Mesh:
      return read_mesh(as(new Mesh()));
    case Shape.VectorField:
      return read_vector_field(as(new VectorField()));
    case Shape.PotentialField: {
      const field = as(new PotentialField());
      const count: Vec3 = [field.count(0) ?? 0, field.count(1) ?? 0, field.count(2) ?? 0];
      const coefficients = required(field.coefficientsArray(), 'coefficients');
      if (coefficients.length !== count[0] * count[1] * count[2]) throw new Error('a potential field has too few coefficients');
      return { kind: 'potential_field', count, origin_m: vec3(field.originM()), step_m: field.stepM(), coefficients };
    }
    case Shape.Needle: {
      const needle = as(new Needle());
      const layers = Array.from({ length: needle.layersLength() }, (_, i) => {
        const layer = required(needle.layers(i), 'layer');
        return { thickness_m: layer.thicknessM(), stiffness_N_m: layer.stiffnessNPerM() };
      });
      return { kind: 'needle', layers };
    }
    case Shape.Tissue: {
      const tissue = as(new Tissue());
      return { kind: 'tissue', half_x_m: tissue.halfXM(), half_y_m: tissue.halfYM(), contact_radius_m: tissue.contactRadiusM() };
    }
    case Shape.ForceField:
      return { kind: 'force_field', half_size_m: vec3(as(new ForceField()).halfSizeM()) };
    default:
      throw new Error(`the scene image has a shape of kind ${object.shapeType()}, which this page does not know`);
  }
}

function read_mesh(mesh: Mesh): MeshModel {
  const flags = mesh.flagsArray();
  const positions = read_positions(mesh);
  const corners = new Uint32Array(mesh.trianglesLength() * 3);
  for (let i = 0; i * 3 < corners.length; ++i) {
    const triangle = required(mesh.triangles(i, kTriangle), 'triangle');
    corners.set([triangle.bits0() & kVertexBits, triangle.bits1() & kVertexBits, triangle.bits2() & kVertexBits], i * 3);
  }
  if (corners.some((vertex) => vertex * 3 >= positions.length)) throw new RangeError('vertex');
  const two_sided = flags !== null && flags.some((flag) => flag & TriangleFlag.TwoSided);
  const shading = mesh.cornerNormalsArray();
  if (shading === null) return { kind: 'mesh', positions, normals: null, indices: corners, two_sided };
  if (shading.length !== corners.length) throw new RangeError('normal');
  return { kind: 'mesh', ...split_by_normal(positions, corners, shading), two_sided };
}

// The image has a normal for each corner, graphics one for each vertex: a vertex becomes as many as it has normals.
function split_by_normal(
  from: Float32Array,
  corners: Uint32Array,
  shading: Uint32Array,
): Pick<MeshModel, 'positions' | 'normals' | 'indices'> {
  const known = new Map<number, number>();
  const vertices: number[] = [];
  const bits: number[] = [];
  const indices = corners.map((vertex, i) => {
    const key = vertex * 2 ** 32 + shading[i];
    let index = known.get(key);
    if (index === undefined) {
      index = vertices.length;
      known.set(key, index);
      vertices.push(vertex);
      bits.push(shading[i]);
    }
    return index;
  });
  const positions = new Float32Array(vertices.length * 3);
  const normals = new Float32Array(vertices.length * 3);
  vertices.forEach((vertex, i) => {
    positions.set(from.subarray(vertex * 3, vertex * 3 + 3), i * 3);
    decode_octahedral(bits[i], normals, i * 3);
  });
  return { positions, normals, indices };
}

function read_positions(mesh: Mesh): Float32Array {
  const out = new Float32Array(mesh.verticesLength() * 3);
  for (let i = 0; i * 3 < out.length; ++i) {
    const position = required(required(mesh.vertices(i, kVertex), 'vertex').positionM(kPosition), 'position');
    out[i * 3] = position.x();
    out[i * 3 + 1] = position.y();
    out[i * 3 + 2] = position.z();
  }
  return out;
}

function read_vector_field(field: VectorField): ShapeModel {
  const half_space = (it: { normal(): XYZ; offsetM(): number } | null): HalfSpaceModel => {
    const side = required(it, 'side');
    return { normal: vec3(side.normal()), offset_m: side.offsetM() };
  };
  const subvolumes = Array.from({ length: field.subvolumesLength() }, (_, i) => {
    const subvolume = required(field.subvolumes(i), 'subvolume');
    return {
      sides: Array.from({ length: subvolume.sidesLength() }, (_unused, side) => half_space(subvolume.sides(side))),
      plane: half_space(subvolume.plane()),
      centre_m: vec3(subvolume.centreM()),
      radius_m: subvolume.radiusM(),
    };
  });
  return { kind: 'vector_field', subvolumes, lo_m: vec3(field.loM()), hi_m: vec3(field.hiM()) };
}
