// Sees in the states of a session that a task is fulfilled.
import type { State } from './protocol';
import type { Goal, Task } from './tasks';
import { type Quat, type Vec3, length, sub } from './vector';

interface Tip {
  at_m: Vec3;
  force_N: number;
  touches: boolean;
}

const is_inside = (at: Vec3, where: Goal['where']): boolean =>
  where === undefined || at.every((value, axis) => value >= where.least_m[axis] && value <= where.most_m[axis]);

const turned_deg = (from: Quat, to: Quat): number => {
  const cosine = Math.abs(from.reduce((sum, part, i) => sum + part * to[i], 0));
  return (360 / Math.PI) * Math.acos(Math.min(1, cosine));
};

// How far each tip has come in its touch.
class Strokes {
  private readonly last: (Vec3 | null)[] = [];
  private readonly way_m: number[] = [];

  take(tips: (Tip | null)[], where: Goal['where']): number {
    tips.forEach((tip, arm) => {
      if (tip === null || !tip.touches || !is_inside(tip.at_m, where)) {
        this.last[arm] = null;
        this.way_m[arm] = 0;
        return;
      }
      const last = this.last[arm] ?? tip.at_m;
      const step_m = length(sub(tip.at_m, last));
      if (this.last[arm] && step_m < kLeastStep_m) return; // the noise of a tip at rest is no way
      this.way_m[arm] = (this.way_m[arm] ?? 0) + step_m;
      this.last[arm] = tip.at_m;
    });
    return Math.max(0, ...this.way_m);
  }
}
const kLeastStep_m = 0.0002;

export class TaskWatch {
  private readonly met: boolean[];
  private readonly open: boolean[]; // what holds from the start on is nobody's doing, until it has ended
  private readonly strokes: Strokes[];
  private first: State | null = null; // what was there before
  private readonly lowest_m = new Map<number, number>(); // heights of the bodies: one may be held up when it begins

  // names: of the scene's objects.
  constructor(
    private readonly task: Task,
    private readonly names: readonly string[],
  ) {
    this.met = task.goals.map(() => false);
    this.open = task.goals.map(() => false);
    this.strokes = task.goals.map(() => new Strokes());
  }

  get goals_met(): number {
    return this.met.filter(Boolean).length;
  }
  get done(): boolean {
    return this.goals_met === this.met.length;
  }

  take(state: State): void {
    if (state.mode !== 'armed') return;
    this.first ??= state;
    for (const { object, position_m } of state.bodies ?? [])
      this.lowest_m.set(object, Math.min(this.lowest_m.get(object) ?? Infinity, position_m[2]));
    this.task.goals.forEach((goal, i) => {
      const holds = this.holds(goal, state, this.strokes[i]);
      this.met[i] ||= holds && this.open[i];
      this.open[i] ||= !holds;
    });
  }

  private holds(goal: Goal, state: State, strokes: Strokes): boolean {
    const tips = state.arms.map((arm): Tip | null =>
      arm === null ? null : { at_m: arm.tip_m, force_N: length(arm.force_N ?? [0, 0, 0]), touches: (arm.contacts ?? 0) > 0 },
    );
    const way_m = strokes.take(tips, goal.where);
    const is_there = (tip: Tip | null) => tip !== null && is_inside(tip.at_m, goal.where) && tip.force_N >= (goal.force_N ?? 0);
    return (
      tips.some(is_there) &&
      (goal.stroked_m === undefined || way_m >= goal.stroked_m) &&
      (goal.touching === undefined || tips.filter((tip) => tip?.touches).length === goal.touching) &&
      (goal.tissue_m === undefined || (state.tissues ?? []).some(({ depth_m }) => depth_m >= (goal.tissue_m as number))) &&
      (goal.torn === undefined || (state.needles ?? []).some(({ torn }) => torn >= (goal.torn as number))) &&
      (goal.control === undefined || this.control_is(goal.control, state)) &&
      (goal.body === undefined || this.body_is(goal.body, state))
    );
  }

  private control_is({ object, on, moved }: NonNullable<Goal['control']>, state: State): boolean {
    const now = state.controls?.find((one) => this.names[one.object] === object);
    const before = this.first?.controls?.find((one) => one.object === now?.object);
    if (now === undefined || before === undefined) return false;
    return (on === undefined || now.on === on) && (moved === undefined || Math.abs(now.q - before.q) >= moved);
  }

  private body_is(wanted: NonNullable<Goal['body']>, state: State): boolean {
    return (state.bodies ?? []).some((now) => {
      const before = this.first?.bodies?.find((one) => one.object === now.object);
      if (before === undefined || (wanted.object !== undefined && this.names[now.object] !== wanted.object)) return false;
      const raised_m = now.position_m[2] - (this.lowest_m.get(now.object) as number);
      return (
        raised_m >= (wanted.raised_m ?? 0) &&
        length(sub(now.position_m, before.position_m)) >= (wanted.moved_m ?? 0) &&
        turned_deg(before.rotation, now.rotation) >= (wanted.turned_deg ?? 0)
      );
    });
  }
}
