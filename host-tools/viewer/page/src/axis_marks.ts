// What a commissioning marks in the picture of an arm: the axis in question with an arrow of its positive direction, the way that a prompt asks for, and
// where it wants the arm.
import { BufferGeometry, ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';

import type { CommissionState } from './protocol';
import { kSeat } from './framing';
import { type Vec3, add, cross, dot, length, scale, sub, unit } from './vector';

export const kAxisColor = 0xd6249f;
export const kWayColor = 0xff7a00;
export const kGoalColor = 0x2eb872;

const kArc_rad = 1.5 * Math.PI;
const kArcPoints = 40;
const kUp = new Vector3(0, 1, 0);
const kRod = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0); // from the origin along y
const kHead = new ConeGeometry(1, 1, 20).translate(0, -0.5, 0); // its tip at the origin

// An arrow as points; the last one is its end.
export type ArrowPath = Vec3[];

// About a line, by the right-hand rule.
export function turning_arrow(at_m: Vec3, direction: Vec3, radius_m: number): ArrowPath {
  const along = unit(direction);
  // The arc ends where it is nearest to the user, so that its head is seen from the side.
  const seat = kSeat.toArray() as Vec3;
  const towards = sub(seat, scale(along, dot(seat, along)));
  const ahead = unit(length(towards) > 0.05 ? scale(towards, -1) : cross(along, [0, 0, 1]));
  const side = cross(ahead, along);
  return Array.from({ length: kArcPoints + 1 }, (_, i) => {
    const angle = (kArc_rad * i) / kArcPoints;
    return add(at_m, add(scale(side, radius_m * Math.cos(angle)), scale(ahead, radius_m * Math.sin(angle))));
  });
}

export const straight_arrow = (from_m: Vec3, direction: Vec3, size_m: number): ArrowPath => [
  from_m,
  add(from_m, scale(unit(direction), size_m)),
];

// Of a motion of the axis: `sign` times its positive direction.
export function axis_arrow({ slides, at_m, direction }: NonNullable<CommissionState['axis']>, sign: number, size_m: number): ArrowPath {
  const way = scale(direction, sign);
  return slides ? straight_arrow(at_m, way, 2 * size_m) : turning_arrow(at_m, way, size_m);
}

class Rods extends Group {
  constructor(private readonly color: number) {
    super();
  }
  // Through hidden parts, too: it says what to look at.
  private add_mesh(geometry: BufferGeometry, at: Vec3, along: Vec3, scales: Vec3): void {
    const mesh = new Mesh(geometry, new MeshBasicMaterial({ color: this.color, depthTest: false, fog: false }));
    mesh.renderOrder = 12;
    mesh.position.set(...at);
    mesh.quaternion.setFromUnitVectors(kUp, new Vector3(...unit(along)));
    mesh.scale.set(...scales);
    this.add(mesh);
  }
  rod(from: Vec3, to: Vec3, radius_m: number): void {
    const way = sub(to, from);
    if (length(way) > 1e-6) this.add_mesh(kRod, from, way, [radius_m, length(way), radius_m]);
  }
  arrow(path: ArrowPath, radius_m: number): void {
    const head_m = 7 * radius_m;
    for (let i = 1; i < path.length; ++i) {
      const last = i === path.length - 1;
      this.rod(path[i - 1], path[i], last && path.length > 2 ? radius_m / 2 : radius_m);
    }
    const [before, end] = path.slice(-2);
    const way = unit(sub(end, before));
    this.add_mesh(kHead, add(end, scale(way, head_m)), way, [0.45 * head_m, head_m, 0.45 * head_m]);
  }
  empty(): void {
    for (const child of [...this.children]) {
      this.remove(child);
      if (child instanceof Mesh) (child.material as MeshBasicMaterial).dispose();
    }
  }
}

export class AxisMarks {
  readonly group = new Group();
  private readonly axis = new Rods(kAxisColor);
  private readonly way = new Rods(kWayColor);
  private readonly goal = new Rods(kGoalColor);
  private shown = '';

  constructor() {
    this.group.add(this.axis, this.way, this.goal);
  }

  // size_m: of the arm. False: nothing has changed.
  update(state: CommissionState, tip_m: Vec3, size_m: number): boolean {
    const { axis, turn, way, goal_m } = state;
    const text = JSON.stringify([axis, turn, way, goal_m, tip_m, size_m]);
    if (text === this.shown) return false;
    this.shown = text;
    this.axis.empty();
    this.way.empty();
    this.goal.empty();
    const radius_m = 0.009 * size_m;
    const arrow_m = 0.14 * size_m;
    if (axis) {
      const half = scale(axis.direction, 1.1 * arrow_m);
      this.axis.rod(sub(axis.at_m, half), add(axis.at_m, half), 1.6 * radius_m);
      this.axis.arrow(axis_arrow(axis, 1, arrow_m), radius_m);
      // The arrow of the way at the joint is outside of the other one.
      if (turn) this.way.arrow(axis_arrow(axis, turn, 1.35 * arrow_m), radius_m);
    }
    if (way) this.way.arrow(straight_arrow(tip_m, way, 0.2 * size_m), 1.3 * radius_m);
    for (const line of goal_m ?? []) line.slice(1).forEach((to, i) => this.goal.rod(line[i], to, 0.6 * radius_m));
    return true;
  }
}
