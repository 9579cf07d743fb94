// How far the tip is from what it may touch: a line straight down to what lies below with a soft shadow at its end, and a ring on the
// nearest point of a surface. Their colour says far, near, touching.
import { Color, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry, Vector3, Float32BufferAttribute } from 'three';

import { Mark } from './mark';
import type { ArmState } from './protocol';
import type { SurfacePoint, Surfaces } from './surfaces';
import { type Vec3, add, scale } from './vector';

export const kFarColor = 0x7d8794;
export const kNearColor = 0x00a3c7;
export const kTouchColor = 0xe0147a;
const kFar_m = 0.05;
const kLift_m = 0.0004; // over the surface
const kRing_px = 19;
const kSegments = 32;
const kShades = [1, 0.8, 0]; // from the middle to the rim
const kLine_px = 1.1;
const kShadow_px = 9; // at least, as wide as the tip is drawn
const kShadowFar_m = 0.12; // from here on there is none
const kZ = new Vector3(0, 0, 1);

const kRod = new CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0); // from the origin along y
const kRing = new RingGeometry(0.72, 1, 40);
const kBlob = blob();

// Dark in the middle, clear at the rim.
function blob(): RingGeometry {
  const disc = new RingGeometry(0.001, 1, kSegments, 2);
  const colors = new Float32Array(4 * disc.getAttribute('position').count);
  kShades.forEach((shade, row) => {
    for (let i = 0; i <= kSegments; ++i) colors[4 * (row * (kSegments + 1) + i) + 3] = shade;
  });
  disc.setAttribute('color', new Float32BufferAttribute(colors, 4));
  return disc;
}

// clearance_m: from the skin of the tip to the surface.
export function depth_color(clearance_m: number, touches: boolean): Color {
  if (touches || clearance_m <= 0) return new Color(kTouchColor);
  return new Color(kNearColor).lerp(new Color(kFarColor), Math.min(clearance_m / kFar_m, 1));
}

export class DepthMarks {
  readonly group = new Group();
  private readonly line = new Mark(kRod, kFarColor, 0.35);
  private readonly ring = new Mark(kRing, kFarColor, 0.5);
  private readonly shadow = new Mesh(
    kBlob,
    new MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false, side: DoubleSide, fog: false }),
  );
  nearest: SurfacePoint | null = null;
  below: SurfacePoint | null = null;
  clearance_m: number | null = null;

  constructor() {
    this.shadow.renderOrder = 1;
    this.group.add(this.line, this.ring, this.shadow);
  }

  update(it: ArmState, surfaces: Surfaces | null, tip_radius_m: number, px_m: number): void {
    const touches = (it.contacts ?? 0) > 0;
    // A tip that touches is inside by a little: what lies below it is what it touches.
    const from = add(touches ? (it.god_m ?? it.tip_m) : it.tip_m, [0, 0, touches ? kLift_m : 0]);
    this.nearest = surfaces?.nearest(it.tip_m) ?? null;
    this.below = surfaces?.below(from) ?? null;
    this.clearance_m = this.nearest && this.nearest.distance_m - tip_radius_m;
    const color = depth_color(this.clearance_m ?? Infinity, touches);
    this.show_ring(color, px_m);
    this.line.visible = this.shadow.visible = this.below !== null;
    if (this.below === null) return;
    this.line.stretch(it.tip_m, this.below.point, kLine_px * px_m);
    this.line.color(color);
    this.show_shadow(this.below, Math.max(tip_radius_m, kShadow_px * px_m));
  }

  private show_ring(color: Color, px_m: number): void {
    this.ring.visible = this.nearest !== null;
    if (this.nearest === null) return;
    lay(this.ring, this.nearest);
    this.ring.scale.setScalar(kRing_px * px_m);
    this.ring.color(color);
  }

  // The higher the tip, the wider and fainter.
  private show_shadow(below: SurfacePoint, radius_m: number): void {
    const share = Math.min(Math.max(below.distance_m, 0) / kShadowFar_m, 1);
    lay(this.shadow, below);
    this.shadow.scale.setScalar(radius_m * (1.5 + 1.2 * share));
    this.shadow.material.opacity = 0.75 * (1 - share);
  }
}

function lay(mark: Group | Mesh, { point, normal }: { point: Vec3; normal: Vec3 }): void {
  mark.position.set(...add(point, scale(normal, kLift_m)));
  mark.quaternion.setFromUnitVectors(kZ, new Vector3(...normal));
}
