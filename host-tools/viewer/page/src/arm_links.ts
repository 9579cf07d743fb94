// The links of an arm as rods from joint to joint, and balls at the joints. They are translucent, so that they do not hide what the tip touches.
import { CylinderGeometry, Group, Mesh, MeshLambertMaterial, SphereGeometry, Vector3 } from 'three';

import { type Vec3, length, sub } from './vector';

const kRadius_m = 0.003;
const kLeast_px = 2;
const kUp = new Vector3(0, 1, 0);
const kRod = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0); // from the origin along y
const kBall = new SphereGeometry(1.4, 16, 12);
const kMaterial = new MeshLambertMaterial({ color: 0x8a929e, transparent: true, opacity: 0.55 });

export class ArmLinks {
  readonly group = new Group();
  private readonly rods: Mesh[] = [];
  private readonly balls: Mesh[] = [];

  // lines: points from joint to joint; undefined: nothing is known of them. Returns the number of rods that are shown.
  update(lines: readonly (readonly Vec3[])[] | undefined, pixel_m: (at: Vec3) => number): number {
    let count = 0;
    for (const line of lines ?? []) {
      for (let i = 1; i < line.length; ++i) {
        this.show(count, line[i - 1], line[i], Math.max(kRadius_m, kLeast_px * pixel_m(line[i])));
        ++count;
      }
    }
    for (let i = count; i < this.rods.length; ++i) this.rods[i].visible = this.balls[i].visible = false;
    return count;
  }

  private show(index: number, from: Vec3, to: Vec3, radius_m: number): void {
    if (index === this.rods.length) {
      this.rods.push(new Mesh(kRod, kMaterial));
      this.balls.push(new Mesh(kBall, kMaterial));
      this.group.add(this.rods[index], this.balls[index]);
    }
    const [rod, ball] = [this.rods[index], this.balls[index]];
    const size_m = Math.max(length(sub(to, from)), 1e-6);
    rod.visible = ball.visible = true;
    rod.position.set(...from);
    rod.quaternion.setFromUnitVectors(kUp, new Vector3(...sub(to, from)).divideScalar(size_m));
    rod.scale.set(radius_m, size_m, radius_m);
    ball.position.set(...from);
    ball.scale.setScalar(radius_m);
  }
}
