// What is heard of the forces of a tick: one number for three components and one or two arms. A steady push is silent, and so is free space.
//
// Each component passes a play, which leaves out what goes to and fro by less, and a high-pass. What is left is projected onto the direction in which the force has changed most of late. The sum of the
// components would cancel where two of them change against each other; their magnitude would double the pitch.
const kHigh_pass_Hz = 20;
const kMemory_s = 0.03; // of the direction
const kPlay_N = 0.03; // one step of an encoder (0.03 mm) against 1000 N/m: a hand that holds still must not tick
const kSilence_N = 1e-6; // a decaying rest below this is nothing

class ArmSignal {
  private readonly before = [0, 0, 0];
  private readonly passed = [0, 0, 0];
  private readonly direction = [1, 1, 1].map((part) => part / Math.sqrt(3));
  private readonly mean = [...this.direction]; // of the changes, each with the sign that agrees with the direction
  private readonly keep: number;
  private readonly forget: number;

  constructor(rate_Hz: number) {
    this.keep = Math.exp((-2 * Math.PI * kHigh_pass_Hz) / rate_Hz);
    this.forget = Math.exp(-1 / (kMemory_s * rate_Hz));
  }

  begin(forces_N: Float32Array, at: number): void {
    for (let axis = 0; axis < 3; ++axis) {
      this.before[axis] = forces_N[at + axis]; // behind the play
      this.passed[axis] = 0;
    }
  }

  take(forces_N: Float32Array, at: number): number {
    for (let axis = 0; axis < 3; ++axis) {
      const force_N = forces_N[at + axis];
      const now = Math.min(Math.max(this.before[axis], force_N - kPlay_N), force_N + kPlay_N);
      const passed = this.keep * (this.passed[axis] + now - this.before[axis]);
      this.passed[axis] = Math.abs(passed) < kSilence_N ? 0 : passed;
      this.before[axis] = now;
    }
    const sign = this.along(this.direction) < 0 ? -1 : 1;
    for (let axis = 0; axis < 3; ++axis) this.mean[axis] = this.forget * this.mean[axis] + sign * this.passed[axis];
    const size = Math.hypot(...this.mean);
    if (size > kSilence_N) for (let axis = 0; axis < 3; ++axis) this.direction[axis] = this.mean[axis] / size;
    return this.along(this.direction);
  }

  private along(direction: readonly number[]): number {
    return direction[0] * this.passed[0] + direction[1] * this.passed[1] + direction[2] * this.passed[2];
  }
}

export class ForceSignal {
  private readonly arms: ArmSignal[];

  constructor(rate_Hz: number, arms: number) {
    this.arms = Array.from({ length: arms }, () => new ArmSignal(rate_Hz));
  }

  // These forces are no change: ticks are missing before them.
  begin(forces_N: Float32Array, at: number): void {
    this.arms.forEach((arm, index) => arm.begin(forces_N, at + 3 * index));
  }
  // In newtons.
  take(forces_N: Float32Array, at: number): number {
    return this.arms.reduce((sum, arm, index) => sum + arm.take(forces_N, at + 3 * index), 0);
  }
}
