// The shortest way of a tip out of an object that it is inside of, in the picture and in words.
import { ConeGeometry, CylinderGeometry, Group, Vector3 } from 'three';

import { Mark } from './mark';
import type { ArmState, State } from './protocol';
import type { Surfaces } from './surfaces';
import { type Vec3, add, length, scale, sub, unit } from './vector';

export const kWayOutColor = 0xb3001b;
const kHead_px = 14;
const kShaft_px = 2.5;
const kUp = new Vector3(0, 1, 0);
const kRod = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0); // from the origin along y
const kHead = new ConeGeometry(1, 1, 20).translate(0, -0.5, 0); // its tip at the origin

export function way_out(surfaces: Surfaces | null, tip_m: Vec3, object: number, tip_radius_m: number): Vec3 | null {
  const surface = surfaces?.nearest(tip_m, object);
  if (!surface) return null;
  return add(sub(surface.point, tip_m), scale(surface.normal, tip_radius_m));
}

// As the user sees it from the seat.
const kWords = [
  ['left', 'right'],
  ['towards you', 'away from you'],
  ['down', 'up'],
];
const kPart = 0.4; // of the way: less is not said

export function way_text(way: Vec3): string {
  const parts = unit(way)
    .map((share, axis) => ({ share: Math.abs(share), word: kWords[axis][share < 0 ? 0 : 1] }))
    .filter(({ share }) => share > kPart)
    .sort((a, b) => b.share - a.share);
  return `${parts.map(({ word }) => word).join(' and ')} by ${Math.max(Math.ceil(length(way) * 1000), 1)} mm`;
}

// What each tip has to leave before it is felt; empty if there is nothing.
export function inside_text(state: State, names: readonly string[], way: (tip_m: Vec3, object: number) => Vec3 | null): string {
  const told = state.arms.flatMap((it, arm) =>
    (it?.inside ?? []).map((object) => {
      const out = way((it as ArmState).tip_m, object);
      const who = state.arms.length > 1 ? `Arm ${arm} is inside` : 'Inside';
      const name = names[object] ?? `object ${object}`;
      return `${who}: move ${out === null ? 'out' : way_text(out)} to leave ${name}.`;
    }),
  );
  return told.join(' ');
}

// From the tip to where it is outside.
export class WayOutMark {
  readonly group = new Group();
  private readonly shaft = new Mark(kRod, kWayOutColor, 1);
  private readonly head = new Mark(kHead, kWayOutColor, 1);

  constructor() {
    this.group.add(this.shaft, this.head);
  }

  update(it: ArmState, surfaces: Surfaces | null, tip_radius_m: number, px_m: number): void {
    const way = it.inside?.length ? way_out(surfaces, it.tip_m, it.inside[0], tip_radius_m) : null;
    this.group.visible = way !== null && length(way) > 0;
    if (way === null || !this.group.visible) return;
    const end = add(it.tip_m, way);
    const head_m = Math.min(kHead_px * px_m, 0.7 * length(way));
    this.shaft.stretch(it.tip_m, sub(end, scale(unit(way), head_m)), Math.min(kShaft_px * px_m, 0.3 * head_m));
    this.head.position.set(...end);
    this.head.quaternion.setFromUnitVectors(kUp, new Vector3(...unit(way)));
    this.head.scale.set(0.4 * head_m, head_m, 0.4 * head_m);
  }
}
