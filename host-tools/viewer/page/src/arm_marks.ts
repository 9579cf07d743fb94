// What is shown of an arm: its tip, the god object, the planes that hold it, the force, and the hand with the line that the force
// stretches. Shared geometry; an update only moves things.
import { CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';

import { ArmLinks } from './arm_links';
import { DepthMarks } from './depth_marks';
import type { Axes } from './drag_mapping';
import { kArrow_m_per_N, kNeedleLength_m } from './lengths';
import { Mark } from './mark';
import { MoveMarks } from './move_marks';
import type { ArmState, State } from './protocol';
import type { SceneModel } from './scene_image';
import type { Surfaces } from './surfaces';
import { type Vec3, add, length, rotate, scale, sub } from './vector';
import { WayOutMark } from './way_out';

export const kArmColors = [0x2f7de1, 0xb14fc5];
export const kForceColor = 0xff7a00;
const kGodColor = 0xe0b000;
const kPlaneColor = 0x2eb872;
const kHandColor = 0xe5484d;
const kSizes_px = { tip: 6.5, god: 4.5, hand: 4.5, shaft: 2, pull: 1.5, needle: 1.5, head: 14, plane: 22 }; // at least, radii and the head's length
const kLeastForce_N = 0.005;
const kPlanes = 3;

const kUp = new Vector3(0, 1, 0);
const kBall = new SphereGeometry(1, 24, 16);
const kRod = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0); // from the origin along y
const kHead = new ConeGeometry(1, 1, 20).translate(0, -0.5, 0); // its tip at the origin
const kDisc = new CircleGeometry(1, 40);

export class ArmMarks {
  readonly group = new Group();
  private readonly tip: Mark;
  private readonly god = new Mark(kBall, kGodColor, 0.8);
  private readonly shaft = new Mark(kRod, kForceColor, 1);
  private readonly head = new Mark(kHead, kForceColor, 1);
  private readonly hand: Mark;
  private readonly pull = new Mark(kRod, kHandColor, 0.7);
  private readonly needle = new Mark(kRod, 0x8a929e, 0.5, true);
  private readonly planes: Mesh[] = [];
  private readonly links = new ArmLinks();
  private readonly way_out = new WayOutMark();
  private readonly moves = new MoveMarks();
  readonly depth = new DepthMarks();
  axes: Axes | null = null; // along which the hand is being moved
  shown_links = 0;

  constructor(readonly arm: number) {
    const color = kArmColors[arm % kArmColors.length];
    this.tip = new Mark(kBall, color, 0.6, true);
    this.hand = new Mark(kBall, kHandColor, 0.7);
    for (let i = 0; i < kPlanes; ++i) {
      const material = new MeshBasicMaterial({
        color: kPlaneColor,
        transparent: true,
        opacity: 0.4,
        side: DoubleSide,
        depthTest: false,
        fog: false,
      });
      const disc = new Mesh(kDisc, material);
      disc.renderOrder = 9;
      this.planes.push(disc);
    }
    this.group.add(this.tip, this.god, this.shaft, this.head, this.hand, this.pull, this.needle, this.links.group, ...this.planes);
    this.group.add(this.depth.group, this.way_out.group, this.moves.group);
    this.group.visible = false;
  }

  // pixel_m: the length of a screen pixel at a place. Marks have a constant size on the screen, arrows and lines their true length.
  update(state: State, scene: SceneModel | null, surfaces: Surfaces | null, pixel_m: (at: Vec3) => number): void {
    const it = state.arms[this.arm];
    this.group.visible = Boolean(it);
    this.shown_links = 0;
    if (!it) return;
    this.shown_links = this.links.update(it.links_m, pixel_m);
    const px_m = pixel_m(it.tip_m);
    const radius_m = scene?.tip_radius_m ?? 0; // 0: points, drawn as small balls
    this.tip.scale.setScalar(radius_m || Math.max(0.0025, kSizes_px.tip * px_m));
    this.god.scale.setScalar(radius_m || Math.max(0.0017, kSizes_px.god * px_m));
    this.hand.scale.setScalar(Math.max(0.0017, kSizes_px.hand * px_m));
    for (const disc of this.planes) disc.scale.setScalar(Math.max(0.008, kSizes_px.plane * px_m));
    this.tip.place(it.tip_m);
    this.show_contact(it, radius_m);
    this.show_force(it, px_m);
    // A hand that is where the tip is would hide it.
    const apart = it.hand_m !== undefined && length(sub(it.hand_m, it.tip_m)) > kSizes_px.hand * px_m;
    this.hand.visible = this.pull.visible = apart;
    if (it.hand_m && apart) {
      this.hand.place(it.hand_m);
      this.pull.stretch(it.tip_m, it.hand_m, Math.max(0.0006, kSizes_px.pull * px_m));
    }
    this.moves.update(it.hand_m ?? it.tip_m, this.axes, px_m);
    this.show_needle(state, it, scene, px_m);
    this.depth.update(it, surfaces, radius_m, px_m);
    this.way_out.update(it, surfaces, radius_m, px_m);
  }

  private show_contact(it: ArmState, radius_m: number): void {
    const touches = (it.contacts ?? 0) > 0;
    this.god.visible = it.god_m !== undefined && touches;
    if (it.god_m) this.god.position.set(...it.god_m);
    this.planes.forEach((disc, i) => {
      const normal = it.planes?.[i]?.normal;
      disc.visible = normal !== undefined && it.god_m !== undefined && touches;
      if (normal === undefined || it.god_m === undefined) return;
      const unit = scale(normal, 1 / length(normal));
      disc.position.set(...sub(it.god_m, scale(unit, radius_m))); // where the sphere touches
      disc.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...unit));
    });
  }

  // From the tip, in the direction in which the device pushes the hand.
  private show_force(it: ArmState, px_m: number): void {
    const force: Vec3 = it.force_N ?? [0, 0, 0];
    const size_N = length(force);
    this.shaft.visible = this.head.visible = size_N > kLeastForce_N;
    if (!this.head.visible) return;
    const size_m = size_N * kArrow_m_per_N;
    const head_m = Math.min(Math.max(0.007, kSizes_px.head * px_m), size_m / 2);
    const direction = scale(force, 1 / size_N);
    this.shaft.stretch(
      it.tip_m,
      add(it.tip_m, scale(direction, size_m - head_m)),
      Math.min(Math.max(0.0009, kSizes_px.shaft * px_m), head_m * 0.3),
    );
    this.head.position.set(...add(it.tip_m, scale(direction, size_m)));
    this.head.quaternion.setFromUnitVectors(kUp, new Vector3(...direction));
    this.head.scale.set(head_m * 0.45, head_m, head_m * 0.45);
  }

  // The needle points along the object's z; in a hole it follows the hole.
  private show_needle(state: State, it: ArmState, scene: SceneModel | null, px_m: number): void {
    const index = scene?.objects.findIndex((object) => object.shape.kind === 'needle') ?? -1;
    this.needle.visible = index >= 0;
    if (scene === null || index < 0) return;
    const object = scene.objects[index];
    const axis = rotate(object.rotation, [0, 0, 1]);
    const track = state.needles?.find((needle) => needle.object === index && needle.arm === this.arm && needle.inside);
    let point = it.tip_m;
    if (track) {
      point = add(object.position_m, rotate(object.rotation, [track.at_m[0], track.at_m[1], -track.depth_m]));
    }
    const top = add(point, scale(axis, kNeedleLength_m));
    this.needle.stretch(point, top, Math.max(0.0007, kSizes_px.needle * px_m));
  }
}
