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
  return { min: -round_up(-least), max: Math.max(round_up(most), at_least) };
}

function round_up(value: number): number {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((it) => it * power >= value) ?? 10;
  return step * power;
}
