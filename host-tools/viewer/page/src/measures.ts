// The numbers that the page shows of one arm.
import type { ArmState, State } from './protocol';
import { length, sub } from './vector';

export const kMeasures = ['force', 'depth', 'velocity', 'energy'] as const;
export type Measure = (typeof kMeasures)[number];

export const kUnits: Record<Measure, string> = { force: 'N', depth: 'mm', velocity: 'mm/s', energy: 'mJ' };
const kDigits: Record<Measure, number> = { force: 2, depth: 2, velocity: 0, energy: 2 };

// How far the tip is behind the surface: from the god object where there is one; else in tissue or below the skin. In metres.
export function depth_m(state: State, arm: number): number {
  const it = state.arms[arm];
  if (!it) return 0;
  if ((it.contacts ?? 0) > 0 && it.god_m) return length(sub(it.god_m, it.tip_m));
  let depth = 0;
  for (const tissue of state.tissues ?? []) if (tissue.arm === arm && tissue.pressed) depth = Math.max(depth, tissue.depth_m);
  for (const needle of state.needles ?? []) if (needle.arm === arm && needle.inside) depth = Math.max(depth, needle.depth_m);
  return depth;
}

const size = (it: ArmState | null, key: 'force_N' | 'velocity_m_s'): number | null => {
  const vector = it?.[key];
  return vector ? length(vector) : null;
};

// In the unit of kUnits; null where it is not known.
export function measure(state: State, arm: number, what: Measure): number | null {
  const it = state.arms[arm];
  if (!it) return null;
  switch (what) {
    case 'force':
      return size(it, 'force_N');
    case 'depth':
      return depth_m(state, arm) * 1000;
    case 'velocity': {
      const speed = size(it, 'velocity_m_s');
      return speed === null ? null : speed * 1000;
    }
    case 'energy':
      return it.energy_J === undefined ? null : it.energy_J * 1000;
  }
}

export function measure_text(state: State, arm: number, what: Measure): string {
  const value = measure(state, arm, what);
  return value === null ? '-' : `${value.toFixed(kDigits[what])} ${kUnits[what]}`;
}
