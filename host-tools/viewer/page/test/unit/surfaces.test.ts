// Dimples, and the surfaces of volumes.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { sunk_m, surface_m } from '../../src/dimple';
import { subvolume_face, zero_surface } from '../../src/field_surface';

test("a dimple is Boussinesq's: whole below the tip, half as deep at sqrt(2) radii, one third at two", () => {
  const dimple = { x_m: 0.01, y_m: 0, depth_m: 0.003 };
  assert.equal(sunk_m(0.01, 0.004, dimple, 0.005), 0.003);
  assert.ok(Math.abs(sunk_m(0.01 + 0.005 * Math.SQRT2, 0, dimple, 0.005) - 0.0015) < 1e-12);
  assert.ok(Math.abs(sunk_m(0.02, 0, dimple, 0.005) - 0.001) < 1e-12);
  assert.equal(surface_m(0.01, 0, [dimple, { ...dimple, depth_m: 0.005 }], 0.005), -0.005);
  assert.equal(surface_m(0.01, 0, [], 0.005), -0);
});

test('the face of a box field is the square that its pyramid cuts out of its plane', () => {
  const half = 0.02;
  const diagonal = (x: number, y: number) => ({
    normal: [x, y, -1].map((it) => it / Math.SQRT2) as unknown as [number, number, number],
    offset_m: 0,
  });
  const face = subvolume_face(
    {
      sides: [diagonal(1, 0), diagonal(-1, 0), diagonal(0, 1), diagonal(0, -1)],
      plane: { normal: [0, 0, 1], offset_m: half },
      centre_m: [0, 0, 0],
      radius_m: 0,
    },
    [-half, -half, -half],
    [half, half, half],
  );
  let area = 0;
  for (let i = 0; i < face.length; i += 9) {
    for (let k = 0; k < 9; k += 3) {
      assert.ok(Math.abs(face[i + k + 2] - half) < 1e-6);
      assert.ok(Math.abs(Math.abs(face[i + k]) - half) < 1e-5 && Math.abs(Math.abs(face[i + k + 1]) - half) < 1e-5);
    }
    const [ax, ay, bx, by] = [face[i + 3] - face[i], face[i + 4] - face[i + 1], face[i + 6] - face[i], face[i + 7] - face[i + 1]];
    area += (ax * by - ay * bx) / 2;
  }
  assert.ok(Math.abs(area - 4 * half * half) < 1e-6, `${area}`);
});

test('the zero of a ball is a ball, turned outwards', () => {
  // A quadratic is its own spline up to a constant: coefficients of r^2 are r^2 less step^2 / 3 an axis.
  const n = 24;
  const step_m = 0.002;
  const radius_m = 0.018;
  const origin = -((n - 1) / 2) * step_m;
  const coefficients = new Float32Array(n ** 3);
  let at = 0;
  for (let k = 0; k < n; ++k)
    for (let j = 0; j < n; ++j)
      for (let i = 0; i < n; ++i) {
        const [x, y, z] = [i, j, k].map((it) => origin + it * step_m);
        coefficients[at++] = radius_m ** 2 - (x * x + y * y + z * z - step_m * step_m);
      }
  const triangles = zero_surface({ kind: 'potential_field', count: [n, n, n], origin_m: [origin, origin, origin], step_m, coefficients });
  let volume = 0;
  for (let i = 0; i < triangles.length; i += 9) {
    const t = triangles.subarray(i, i + 9);
    for (let k = 0; k < 9; k += 3) assert.ok(Math.abs(Math.hypot(t[k], t[k + 1], t[k + 2]) - radius_m) < 0.15 * step_m);
    volume += (t[0] * (t[4] * t[8] - t[5] * t[7]) - t[1] * (t[3] * t[8] - t[5] * t[6]) + t[2] * (t[3] * t[7] - t[4] * t[6])) / 6;
  }
  const exact = (4 / 3) * Math.PI * radius_m ** 3;
  assert.ok(Math.abs(volume / exact - 1) < 0.02, `${volume} ${exact}`);
});
