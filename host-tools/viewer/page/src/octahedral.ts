// Unit vectors in 32 bits, as in control/scene/octahedral.h: low 16 bits x, high 16 bits y, each an int16 / 32767.
export function decode_octahedral(bits: number, out: Float32Array, at: number): void {
  let x = ((bits << 16) >> 16) / 32767;
  let y = (bits >> 16) / 32767;
  const z = 1 - Math.abs(x) - Math.abs(y);
  const fold = z < 0 ? -z : 0;
  x += x < 0 ? fold : -fold;
  y += y < 0 ? fold : -fold;
  const size = Math.hypot(x, y, z);
  out[at] = x / size;
  out[at + 1] = y / size;
  out[at + 2] = z / size;
}
