// The moment that is shown: now, or one of the last 60 s. While it is paused the history shown does not change, and new states
// are still stored.
import { History, kSpan_s } from './history';
import type { State } from './protocol';

export class Timeline {
  readonly live = new History();
  private frozen: History | null = null;
  private time_s = 0;

  get paused(): boolean {
    return this.frozen !== null;
  }
  get shown(): History {
    return this.frozen ?? this.live;
  }
  get newest_s(): number {
    return this.shown.newest?.time_s ?? 0;
  }
  // The moment that is shown, seconds before the newest: 0 to -60.
  get offset_s(): number {
    return this.paused ? this.time_s - this.newest_s : 0;
  }
  get least_offset_s(): number {
    return Math.max((this.shown.oldest?.time_s ?? 0) - this.newest_s, -kSpan_s);
  }
  get until_s(): number {
    return this.paused ? this.time_s : this.newest_s;
  }
  get state(): State | undefined {
    return this.paused ? this.shown.at(this.time_s) : this.live.newest;
  }

  pause(): void {
    if (this.paused || this.live.size === 0) return;
    this.frozen = this.live.copy();
    this.time_s = this.newest_s;
  }
  resume(): void {
    this.frozen = null;
  }
  seek(offset_s: number): void {
    this.pause();
    this.time_s = this.newest_s + Math.min(Math.max(offset_s, this.least_offset_s), 0);
  }
  // Another scene: earlier states do not fit its objects.
  forget(): void {
    this.live.clear();
    this.resume();
  }
}
