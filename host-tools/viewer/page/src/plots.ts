// The curves: force, depth, velocity and energy of each arm against time.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import type { History } from './history';
import { type Measure, kMeasures, kUnits } from './measures';
import { range_of, splits_of } from './ranges';

const kHeight_px = 96;
const kEdge_s = 0.1; // a curve that begins so near to the left edge reaches it
// The least range of the axis, so that noise alone does not fill the plot.
const kLeast: Record<Measure, number> = { force: 0.5, depth: 0.5, velocity: 20, energy: 0.5 };
const kTitles: Record<Measure, string> = { force: 'Force', depth: 'Depth', velocity: 'Speed', energy: 'Energy to the hand' };
// The sign is the force's: what the arm does to the hand.
const kNotes: Partial<Record<Measure, string>> = { energy: ' in this contact (−: from it)' };

export class Plots {
  span_s = 10;
  private readonly still = new Map<Measure, string | null>(); // straight lines that are drawn
  private plots: { what: Measure; plot: uPlot }[] = [];

  constructor(
    private readonly place: HTMLElement,
    private readonly arms: number,
  ) {
    place.replaceChildren();
    for (const what of kMeasures) this.plots.push({ what, plot: this.make(what) });
    const resize = new ResizeObserver(() => {
      this.still.clear();
      for (const { plot } of this.plots) plot.setSize({ width: place.clientWidth, height: kHeight_px });
    });
    resize.observe(place);
    this.dispose = () => {
      resize.disconnect();
      for (const { plot } of this.plots) plot.destroy();
    };
  }

  readonly dispose: () => void;

  // The curves up to a time of the history; time 0 of the axis is the newest there is.
  update(history: History, until_s: number, newest_s: number): void {
    for (const { what, plot } of this.plots) {
      const columns = history.columns(what, this.arms, until_s - this.span_s, until_s);
      columns[0] = columns[0].map((time) => (time as number) - newest_s);
      const still = still_key(columns, until_s - newest_s - this.span_s, until_s - newest_s);
      if (still !== null && still === this.still.get(what)) continue;
      this.still.set(what, still);
      plot.batch(() => {
        plot.setData(columns as uPlot.AlignedData, false);
        plot.setScale('x', { min: until_s - newest_s - this.span_s, max: until_s - newest_s });
        plot.setScale('y', range_of(columns.slice(1), kLeast[what]));
      });
    }
  }

  // Colours come from the style sheet, so that they follow light and dark.
  redraw(): void {
    for (const { plot } of this.plots) plot.redraw();
  }

  private make(what: Measure): uPlot {
    const color = (name: string) => () => getComputedStyle(this.place).getPropertyValue(name).trim();
    const axis: uPlot.Axis = {
      stroke: color('--muted'),
      grid: { stroke: color('--line'), width: 1 },
      ticks: { show: false },
      font: '11px system-ui, sans-serif',
    };
    const figure = document.createElement('figure');
    const caption = document.createElement('figcaption');
    caption.textContent = `${kTitles[what]}${kNotes[what] ?? ''}, ${kUnits[what]}`;
    figure.append(caption);
    this.place.append(figure);
    return new uPlot(
      {
        width: Math.max(this.place.clientWidth, 200),
        height: kHeight_px,
        legend: { show: false },
        cursor: { show: false },
        padding: [6, 8, 0, 0],
        scales: { x: { time: false }, y: { auto: false, range: (_, min, max) => [min, max] } },
        axes: [
          { ...axis, size: 20, values: (_, ticks) => ticks.map((tick) => `${tick} s`) },
          { ...axis, size: 44, splits: (_plot, _axis, min, max) => splits_of(min, max), values: (_, ticks) => ticks.map(short) },
        ],
        series: [{}, ...Array.from({ length: this.arms }, (_, arm) => ({ stroke: color(`--arm-${arm}`), width: 1.5 }))],
      },
      [[], ...Array.from({ length: this.arms }, () => [])] as uPlot.AlignedData,
      figure,
    );
  }
}

// Straight lines from edge to edge look the same as long as they stay where they are; null for other curves.
export function still_key([times, ...columns]: (number | null)[][], from_s: number, to_s: number): string | null {
  if (times.length < 2 || (times[0] as number) > from_s + kEdge_s) return null;
  const values = columns.map(([first]) => first);
  if (!columns.every((column, i) => column.every((it) => it === values[i]))) return null;
  return JSON.stringify([from_s, to_s, values]);
}

const short = (value: number): string => String(Number(value.toPrecision(3)));
