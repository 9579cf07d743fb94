// How a drag on the screen moves the hand. To the side, and in depth: along the lines of the grid, those that are nearest to the screen's
// own directions. Down: straight down in the world, or, where nothing lies below the home of the tip, aslant to what is nearest; so a drag
// down always comes to the scene, after about the same way on the screen. While neither scene nor view changes, equal drags are equal
// motions, and up undoes down.
import type { Surfaces } from './surfaces';
import { type Vec3, dot, length, scale, sub, unit } from './vector';

export const kDrag_px = 80; // from the home to the scene, at most, in the view that a scene begins with
const kSteepest = 0.64; // the cosine of how far from straight down the way may be
const kFromAbove = 0.85; // where the view is steeper than this (58 degrees), a drag up moves away over the grid, and depth is the height

// What a drag down leads to, from the home of a tip.
export interface Reach {
  down: Vec3;
  distance_m: number; // 0: nothing is there
}
export const kNoReach: Reach = { down: [0, 0, -1], distance_m: 0 };

export interface Axes {
  right: Vec3;
  up: Vec3;
  away: Vec3;
}

export interface View extends Axes {
  pixel_m: number; // of what the camera looks at
  zoom: number; // distance of the camera to that of the first view
}

export function reach_of(surfaces: Surfaces, home_m: Vec3): Reach {
  const below = surfaces.along(home_m, kNoReach.down, true);
  if (below !== null) return { ...kNoReach, distance_m: below.distance_m };
  const nearest = surfaces.nearest(home_m);
  if (nearest === null) return kNoReach;
  const way = sub(nearest.point, home_m);
  return -unit(way)[2] < kSteepest ? kNoReach : { down: unit(way), distance_m: length(way) };
}

// What the hand moves along, from what the screen has.
export function hand_axes({ right: [x, y], up, away }: Axes, { down }: Reach): Axes {
  const right: Vec3 = Math.abs(x) >= Math.abs(y) ? [Math.sign(x), 0, 0] : [0, Math.sign(y), 0];
  const level: Vec3 = [0 - right[1], right[0], 0]; // away from the user
  if (Math.abs(away[2]) > kFromAbove) return { right, up: scale(level, Math.sign(dot(up, level))), away: [0, 0, Math.sign(away[2])] };
  return { right, up: scale(down, -1), away: level };
}

// The motion of the hand for a pixel: that of what is seen, or more, where the scene is far.
export const drag_m_per_px = ({ pixel_m, zoom }: View, { distance_m }: Reach): number => Math.max(pixel_m, (zoom * distance_m) / kDrag_px);
