// What the picture shows of a state, as numbers, so that a state that looks the same as the drawn one is not drawn.
import { kArrow_m_per_N, kNeedleLength_m } from './lengths';
import type { ArmState, State } from './protocol';
import { type Vec3, scale } from './vector';

// Directions and angles move points at about this distance.
const kLever_m = 0.05;
// What is there or not: more than any tolerance.
const kFlag_m = 1;

// In metres, or what a change of it moves in metres.
export function visible(state: State): number[] {
  const numbers: number[] = [];
  const at = (place: Vec3 | undefined) => (place ? numbers.push(kFlag_m, ...place) : numbers.push(0));
  const turn = (by: readonly number[], lever_m = kLever_m) => numbers.push(...by.map((it) => it * lever_m));
  const arm = (it: ArmState) => {
    at(it.tip_m);
    at(it.god_m);
    at(it.hand_m);
    at(it.force_N && scale(it.force_N, kArrow_m_per_N));
    numbers.push((it.contacts ?? 0) > 0 ? kFlag_m : 0);
    for (const { normal } of it.planes ?? []) turn(normal);
    numbers.push(...(it.inside ?? []));
    for (const line of it.links_m ?? []) line.forEach(at);
  };
  for (const it of state.arms) {
    numbers.push(it ? kFlag_m : 0);
    if (it) arm(it);
  }
  for (const { object, position_m, rotation } of state.bodies ?? []) {
    numbers.push(object, ...position_m);
    turn(rotation);
  }
  for (const { object, q, on } of state.controls ?? []) numbers.push(object, q, on ? kFlag_m : 0);
  for (const { object, arm, at_m, depth_m } of state.tissues ?? []) numbers.push(object, arm, ...at_m, depth_m);
  for (const { object, arm, inside, at_m, depth_m } of state.needles ?? [])
    numbers.push(object, arm, inside ? kFlag_m : 0, ...at_m, Math.min(depth_m, kNeedleLength_m));
  return numbers;
}

export const looks_same = (a: readonly number[], b: readonly number[], tolerance_m: number): boolean =>
  a.length === b.length && a.every((value, i) => Math.abs(value - b[i]) <= tolerance_m);
