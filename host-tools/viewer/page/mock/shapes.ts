// Signed distances for the mock's tip: exact for plane, sphere and box, a ball of the same size for anything else.
import type { ObjectModel, ShapeModel } from '../src/scene_image';
import { type Quat, type Vec3, add, conjugate, dot, length, rotate, scale, sub, unit } from '../src/vector';

export interface Surface {
  distance_m: number; // below 0 inside
  normal: Vec3;
}

function in_frame(shape: ShapeModel, p: Vec3): Surface {
  switch (shape.kind) {
    case 'plane':
      return { distance_m: dot(shape.normal, p) - shape.offset_m, normal: shape.normal };
    case 'needle':
      return { distance_m: p[2], normal: [0, 0, 1] };
    case 'tissue': {
      const over = Math.abs(p[0]) <= shape.half_x_m && Math.abs(p[1]) <= shape.half_y_m;
      return { distance_m: over ? p[2] : 1, normal: [0, 0, 1] };
    }
    case 'box':
      return box(shape.half_size_m, p);
    default:
      return { distance_m: length(p) - radius_of(shape), normal: unit(p) };
  }
}

function box(half: Vec3, p: Vec3): Surface {
  const over = p.map((value, i) => Math.abs(value) - half[i]);
  const outside = over.map((value) => Math.max(value, 0)) as unknown as Vec3;
  const sign = p.map((value) => (value < 0 ? -1 : 1));
  if (length(outside) > 0) {
    return { distance_m: length(outside), normal: unit([outside[0] * sign[0], outside[1] * sign[1], outside[2] * sign[2]]) };
  }
  const nearest = over.indexOf(Math.max(...over));
  const normal: [number, number, number] = [0, 0, 0];
  normal[nearest] = sign[nearest];
  return { distance_m: over[nearest], normal };
}

function radius_of(shape: ShapeModel): number {
  if (shape.kind === 'mesh') {
    let sum = 0;
    for (let i = 0; i < shape.positions.length; i += 3)
      sum += Math.hypot(shape.positions[i], shape.positions[i + 1], shape.positions[i + 2]);
    return sum / Math.max(shape.positions.length / 3, 1);
  }
  return 'radius_m' in shape ? shape.radius_m : 0.02;
}

export function surface_of(object: ObjectModel, position_m: Vec3, rotation: Quat, p: Vec3): Surface {
  const local = in_frame(object.shape, rotate(conjugate(rotation), sub(p, position_m)));
  return { distance_m: local.distance_m, normal: rotate(rotation, local.normal) };
}

export const on_surface = (p: Vec3, { distance_m, normal }: Surface): Vec3 => add(p, scale(normal, -distance_m));
