// A mark in the picture. What of it is hidden by an object is drawn faintly: a tip is inside the object that it touches.
import { type BufferGeometry, type Color, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, Vector3 } from 'three';

import { type Vec3, length, sub } from './vector';

const kUp = new Vector3(0, 1, 0);

export class Mark extends Group {
  private readonly materials: (MeshBasicMaterial | MeshLambertMaterial)[];

  // shaded: lit as a solid, and with a shadow.
  constructor(geometry: BufferGeometry, color: number, through = 0.4, shaded = false) {
    super();
    const look = { color, fog: false, side: DoubleSide };
    const faint = new MeshBasicMaterial({ ...look, transparent: true, opacity: through, depthTest: false });
    const hidden = new Mesh(geometry, faint);
    hidden.renderOrder = 10;
    const solid = shaded ? new MeshLambertMaterial(look) : new MeshBasicMaterial(look);
    const seen = new Mesh(geometry, solid);
    seen.castShadow = shaded;
    seen.renderOrder = 11;
    this.materials = [faint, solid];
    this.add(hidden, seen);
  }
  place(at: Vec3): void {
    this.position.set(...at);
    this.visible = true;
  }
  color(color: Color): void {
    for (const material of this.materials) material.color.copy(color);
  }
  // A rod from a to b.
  stretch(a: Vec3, b: Vec3, radius_m: number): void {
    const size = length(sub(b, a));
    this.visible = size > 1e-6;
    if (!this.visible) return;
    this.position.set(...a);
    this.quaternion.setFromUnitVectors(kUp, new Vector3(...sub(b, a)).divideScalar(size));
    this.scale.set(radius_m, size, radius_m);
  }
}
