// The states of the last 60 s, for the scrubber and the plots. Times are the controller's.
import { type Measure, measure } from './measures';
import type { State } from './protocol';

export const kSpan_s = 60;
// After this time without a state a curve has a gap.
const kGap_s = 0.5;

export class History {
  private states: State[] = [];
  private first = 0; // states before it are older than the span; they are removed in blocks

  get size(): number {
    return this.states.length - this.first;
  }
  get oldest(): State | undefined {
    return this.states[this.first];
  }
  get newest(): State | undefined {
    return this.states[this.states.length - 1];
  }

  // If the time goes back, the controller has restarted: drop the older states.
  push(state: State): void {
    const newest = this.newest;
    if (newest !== undefined) {
      if (state.time_s < newest.time_s) this.clear();
      else if (state.time_s === newest.time_s) this.states.pop();
    }
    // The telemetry sends objects in turn: an object that a state does not mention keeps its position.
    this.states.push(with_known(state, this.newest));
    while (this.states[this.first].time_s < state.time_s - kSpan_s) ++this.first;
    if (this.first > 1000) {
      this.states.splice(0, this.first);
      this.first = 0;
    }
  }

  clear(): void {
    this.states = [];
    this.first = 0;
  }

  // A copy that does not change while new states arrive.
  copy(): History {
    const other = new History();
    other.states = this.states.slice(this.first);
    return other;
  }

  // The last state at or before the time; the oldest where all are later.
  at(time_s: number): State | undefined {
    const index = this.index_at(time_s);
    return this.states[index];
  }

  // Columns for a plot from `from_s` to `to_s`: times, then one column an arm. A gap is a null.
  columns(what: Measure, arms: number, from_s: number, to_s: number): (number | null)[][] {
    const columns: (number | null)[][] = Array.from({ length: arms + 1 }, () => []);
    let before = -Infinity;
    for (let i = this.index_at(from_s); i < this.states.length && this.states[i].time_s <= to_s; ++i) {
      const state = this.states[i];
      if (state.time_s - before > kGap_s && before !== -Infinity) {
        columns[0].push((state.time_s + before) / 2);
        for (let arm = 0; arm < arms; ++arm) columns[arm + 1].push(null);
      }
      columns[0].push(state.time_s);
      for (let arm = 0; arm < arms; ++arm) columns[arm + 1].push(measure(state, arm, what));
      before = state.time_s;
    }
    return columns;
  }

  private index_at(time_s: number): number {
    let low = this.first;
    let high = this.states.length;
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.states[middle].time_s <= time_s) low = middle + 1;
      else high = middle;
    }
    return Math.max(low - 1, this.first);
  }
}

function with_known(state: State, before: State | undefined): State {
  if (before === undefined) return state;
  return {
    ...state,
    bodies: merge(before.bodies, state.bodies, (body) => body.object),
    controls: merge(before.controls, state.controls, (control) => control.object),
    tissues: merge(before.tissues, state.tissues, (tissue) => tissue.object * 2 + tissue.arm),
    needles: merge(before.needles, state.needles, (needle) => needle.object * 2 + needle.arm),
  };
}

function merge<T>(before: T[] | undefined, now: T[] | undefined, key: (item: T) => number): T[] | undefined {
  if (before === undefined || before === now) return now;
  if (now === undefined) return before;
  const known = new Map(before.map((item) => [key(item), item]));
  for (const item of now) known.set(key(item), item);
  return [...known.values()];
}
