// The ticks that have come and are not heard yet. Where they stop, the sound fades; where they come again, it begins softly.
import { ForceSignal } from './sound_signal';

export interface TickForces {
  forces_N: Float32Array<ArrayBuffer>; // x, y, z of each arm of each tick
  arms: number;
  rate_Hz: number;
}

const kWanted_s = 0.03; // waiting: the worker's timer may be late by that
const kMost_s = 0.15; // more is skipped
const kFade_s = 0.005;
const kMost_trim = 0.01; // of the rate, to keep the wanted delay: the two clocks are not the same

export class SoundQueue {
  private parts: Float32Array[] = [];
  private at = 0; // in the first part
  private waiting = 0; // numbers
  private kind: { arms: number; rate_Hz: number } | null = null;
  private signal: ForceSignal | null = null;
  private starved = true;
  private last = 0;
  private level = 0; // of the fade, 0 to 1
  private decay = 0; // per tick
  gaps = 0; // so far: ticks that did not come in time, or too many at once

  put({ forces_N, arms, rate_Hz }: TickForces): void {
    if (this.kind?.arms !== arms || this.kind.rate_Hz !== rate_Hz) {
      this.parts = [];
      this.at = this.waiting = 0;
      this.kind = { arms, rate_Hz };
      this.signal = new ForceSignal(rate_Hz, arms);
      this.decay = Math.exp(-5 / (kFade_s * rate_Hz));
      this.starve();
    }
    this.parts.push(forces_N);
    this.waiting += forces_N.length;
    if (this.ticks <= kMost_s * rate_Hz) return;
    while (this.ticks > kWanted_s * rate_Hz) this.drop();
    this.starve();
  }

  // Ticks for each sample.
  step(sample_rate_Hz: number): number {
    if (this.kind === null) return 0;
    const wanted = kWanted_s * this.kind.rate_Hz;
    const trim = this.starved ? 0 : kMost_trim * Math.max(-1, Math.min(1, (this.ticks - wanted) / wanted));
    return Math.min(1, (this.kind.rate_Hz * (1 + trim)) / sample_rate_Hz);
  }

  // The signal of the next tick, in newtons.
  next(): number {
    if (this.kind === null || this.signal === null) return 0;
    if (this.starved && this.last === 0 && this.ticks >= kWanted_s * this.kind.rate_Hz) this.begin_again();
    if (!this.starved && this.ticks < 1) this.starve();
    if (this.starved) {
      this.last = Math.abs(this.last) < 1e-6 ? 0 : this.last * this.decay;
      return this.last;
    }
    const value = this.signal.take(this.parts[0], this.at);
    this.drop();
    this.level = Math.min(1, this.level + 1 / (kFade_s * this.kind.rate_Hz));
    this.last = value * this.level;
    return this.last;
  }

  private get ticks(): number {
    return this.waiting / (3 * (this.kind?.arms ?? 1));
  }
  private starve(): void {
    if (!this.starved) ++this.gaps;
    this.starved = true;
    this.level = 0;
  }
  private begin_again(): void {
    this.starved = false;
    this.signal?.begin(this.parts[0], this.at);
  }
  private drop(): void {
    const numbers = 3 * (this.kind?.arms ?? 1);
    this.at += numbers;
    this.waiting -= numbers;
    if (this.at < this.parts[0].length) return;
    this.parts.shift();
    this.at = 0;
  }
}
