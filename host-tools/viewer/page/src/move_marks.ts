// Through a hand that is being moved: the lines along which a drag moves it, and the line of the wheel, of two fingers and of Page Up and Page Down.
import { CylinderGeometry, Group } from 'three';

import type { Axes } from './drag_mapping';
import { Mark } from './mark';
import { type Vec3, add, scale } from './vector';

export const kDragColor = 0xe5484d; // as the hand
export const kDepthColor = 0x4d7a00;
const kHalf_px = 60;
const kThick_px = 1.5;
const kRod = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0); // from the origin along y

export class MoveMarks {
  readonly group = new Group();
  private readonly lines = [kDragColor, kDragColor, kDepthColor].map((color) => new Mark(kRod, color, 0.5));

  constructor() {
    this.group.add(...this.lines);
  }

  // axes: null where it is not being moved.
  update(at: Vec3, axes: Axes | null, px_m: number): void {
    this.group.visible = axes !== null;
    if (axes === null) return;
    [axes.right, axes.up, axes.away].forEach((way, i) => {
      const half = scale(way, kHalf_px * px_m);
      this.lines[i].stretch(add(at, scale(half, -1)), add(at, half), kThick_px * px_m);
    });
  }
}
