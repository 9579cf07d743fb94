// What is above zero gets this much of what is below it, so that the numbers at the axis stand apart.
const kLeastShare = 0.4;

// From 0, or below the least, to the next of 1, 2, 5 ... above the most: a scale that jumps seldom.
export function range_of(columns: (number | null)[][], at_least: number): { min: number; max: number } {
  let most = 0;
  let least = 0;
  for (const column of columns)
    for (const value of column) {
      if (value === null) continue;
      if (value > most) most = value;
      if (value < least) least = value;
    }
  if (least >= 0) return { min: 0, max: Math.max(round_up(most), at_least) };
  const min = -Math.max(round_up(-least), at_least);
  return { min, max: most > 0 ? Math.max(round_up(most), kLeastShare * -min) : 0 };
}

// Where an axis has its numbers: the ends, and zero or the middle between them.
export const splits_of = (min: number, max: number): number[] => [min, min < 0 && max > 0 ? 0 : (min + max) / 2, max];

function round_up(value: number): number {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((it) => it * power >= value) ?? 10;
  return step * power;
}
