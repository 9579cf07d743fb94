// What the curves show, as numbers: the values at one time, and all of them as CSV.
import type { History } from './history';
import { type Measure, kMeasures, kUnits } from './measures';
import type { Window } from './plots';

const kNames: Record<Measure, string> = { force: 'force', depth: 'depth', velocity: 'speed', energy: 'energy' };
const kColumnUnits: Record<Measure, string> = { force: 'N', depth: 'mm', velocity: 'mm_per_s', energy: 'mJ' };
const kDigits: Record<Measure, number> = { force: 3, depth: 3, velocity: 1, energy: 3 };

const columns_of = (history: History, arms: number, { from_s, to_s }: Window) =>
  kMeasures.map((what) => ({ what, columns: history.columns(what, arms, from_s, to_s) }));

// A line a state, times of the controller's clock. The columns of arm 0 have the plain names.
export function csv_of(history: History, arms: number, window: Window): string {
  const all = columns_of(history, arms, window);
  const each = Array.from({ length: arms }, (_, arm) => arm);
  const head = all.flatMap(({ what }) => each.map((arm) => `${kNames[what]}${arm > 0 ? `_${arm}` : ''}_${kColumnUnits[what]}`));
  const lines = [['time_s', ...head].join(',')];
  all[0].columns[0].forEach((time, i) => {
    const values = all.flatMap(({ what, columns }) => each.map((arm) => columns[arm + 1][i]?.toFixed(kDigits[what]) ?? ''));
    // A gap in the curves is no state, and the state before the window only leads the curve in.
    if (values.some((value) => value !== '') && (time as number) >= window.from_s)
      lines.push([(time as number).toFixed(4), ...values].join(','));
  });
  return `${lines.join('\n')}\n`;
}

// The values of all curves at one of their states.
export function values_text(history: History, arms: number, window: Window, newest_s: number, index: number): string {
  const all = columns_of(history, arms, window);
  const time = all[0].columns[0][index];
  if (time === undefined || time === null) return '';
  const parts = all.map(({ what, columns }) => {
    const values = columns.slice(1).map((column) => column[index]?.toFixed(Math.min(kDigits[what], 2)) ?? '-');
    return `${kNames[what]} ${values.join(' and ')} ${kUnits[what]}`;
  });
  return `${(time - newest_s).toFixed(2)} s: ${parts.join(', ')}`;
}

export function download(what: string | Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(typeof what === 'string' ? new Blob([what], { type: 'text/csv' }) : what);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
