// From where a box is seen whole, and how long a pixel is there. Pure geometry.
import { Box3, MathUtils, Vector3 } from 'three';

// From the user's seat, a little above and to the right.
export const kSeat = new Vector3(0.3, -1, 0.55).normalize();
export const kFieldOfView_deg = 40;
const kUp = new Vector3(0, 0, 1);
const kMargin = 1.12; // about the box that is framed
const kSlope = Math.tan(MathUtils.degToRad(kFieldOfView_deg / 2));

// The length of a pixel so far away, in a picture of so many rows.
export const pixel_m_at = (distance_m: number, rows: number): number => (2 * distance_m * kSlope) / Math.max(rows, 1);

// The nearest place in the user's direction from which every corner of the box is inside the picture, and what it looks at.
export function view_of(box: Box3, aspect: number): { target: Vector3; distance_m: number } {
  const center = box.getCenter(new Vector3());
  const right = new Vector3().crossVectors(kUp, kSeat).normalize();
  const up = new Vector3().crossVectors(kSeat, right);
  const high = kSlope / kMargin;
  const fit = (direction: Vector3, slope: number) => {
    let [most, least] = [-Infinity, -Infinity];
    for (const corner of corners_of(box)) {
      const from = corner.sub(center);
      const [side, near] = [from.dot(direction) / slope, from.dot(kSeat)];
      most = Math.max(most, near + side);
      least = Math.max(least, near - side);
    }
    return { distance_m: (most + least) / 2, shift_m: (slope * (most - least)) / 2 };
  };
  const wide = fit(right, high * aspect);
  const tall = fit(up, high);
  const target = center.addScaledVector(right, wide.shift_m).addScaledVector(up, tall.shift_m);
  return { target, distance_m: Math.max(wide.distance_m, tall.distance_m) };
}

const corners_of = ({ min, max }: Box3): Vector3[] =>
  [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => new Vector3(bits & 1 ? max.x : min.x, bits & 2 ? max.y : min.y, bits & 4 ? max.z : min.z));
