// The ghost hand: it leads the hands of the simulated device along the scripted path of the scene, so that force and effects are those of a real
// hand. The user takes over at any time.
import type { HandPath } from './hand_path';
import { type Vec3, add, scale, sub } from './vector';

const kApproach_s = 0.8; // to where the path begins
const kPositions_per_s = 60;

export class Ghost {
  private since_s: number | null = null;
  private due_s = 0;
  private from_m: Vec3[] = [];

  // shown_s: the time of the path at which it ends; then it goes back to where the path began. hand: the hand of an arm goes there.
  constructor(
    private readonly path: HandPath,
    private readonly shown_s: number,
    private readonly hand: (arm: number, position_m: Vec3) => void,
  ) {}

  // Once a frame. hands_m: where the hands are. False: it is over.
  step(now_s: number, hands_m: readonly Vec3[]): boolean {
    if (this.since_s === null) {
      this.since_s = this.due_s = now_s;
      this.from_m = this.arms.map((arm) => hands_m[arm] ?? this.path.at(arm, this.path.from_s));
    }
    const time_s = now_s - this.since_s;
    if (now_s >= this.due_s) {
      this.due_s = Math.max(this.due_s + 1 / kPositions_per_s, now_s);
      for (const arm of this.arms) this.hand(arm, this.at(arm, time_s));
    }
    return time_s < this.length_s;
  }

  // With the way there, and the way back: up first, then home.
  get length_s(): number {
    return kApproach_s + this.played_s + (this.is_cut ? 2 * kApproach_s : 0);
  }

  private at(arm: number, time_s: number): Vec3 {
    const begin = this.path.at(arm, this.path.from_s);
    if (time_s < kApproach_s) return between(this.from_m[arm], begin, time_s / kApproach_s);
    const played_s = Math.min(time_s - kApproach_s, this.played_s);
    const at = this.path.at(arm, this.path.from_s + played_s);
    const back_s = time_s - kApproach_s - this.played_s;
    if (back_s <= 0 || !this.is_cut) return at;
    const above: Vec3 = [at[0], at[1], Math.max(at[2], begin[2])];
    return back_s < kApproach_s ? between(at, above, back_s / kApproach_s) : between(above, begin, back_s / kApproach_s - 1);
  }
  private get arms(): number[] {
    return Array.from({ length: this.path.arm_count }, (_, arm) => arm);
  }
  private get played_s(): number {
    return Math.min(this.shown_s, this.path.until_s) - this.path.from_s;
  }
  private get is_cut(): boolean {
    return this.shown_s < this.path.until_s;
  }
}

const between = (a: Vec3, b: Vec3, part: number): Vec3 => add(a, scale(sub(b, a), Math.min(1, Math.max(0, part))));
