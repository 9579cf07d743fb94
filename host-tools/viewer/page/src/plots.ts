// The curves: force, depth, velocity and energy of each arm against time. A drag across one, or a key, zooms into a part of the time.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import type { History } from './history';
import { type Measure, kMeasures, kUnits } from './measures';
import { range_of, splits_of } from './ranges';

const kHeight_px = 96;
const kEdge_s = 0.1; // a curve that begins so near to the left edge reaches it
const kLeastSpan_s = 0.05;
const kLeastDrag_px = 5;
// The least range of the axis, so that noise alone does not fill the plot.
const kLeast: Record<Measure, number> = { force: 0.5, depth: 0.5, velocity: 20, energy: 0.5 };
const kTitles: Record<Measure, string> = { force: 'Force', depth: 'Depth', velocity: 'Speed', energy: 'Energy to the hand' };
// The sign is the force's: what the arm does to the hand.
const kNotes: Partial<Record<Measure, string>> = { energy: ' in this contact (−: from it)' };

// A part of the history, in the controller's time.
export interface Window {
  from_s: number;
  to_s: number;
}

// What the curves tell: the user wants another part of the time, the live curves, or reads the values at a time (null: at none).
export interface PlotsListener {
  on_zoom(window: Window): void;
  on_live(): void;
  on_cursor(index: number | null): void;
}

export class Plots {
  span_s = 10;
  zoomed: Window | null = null;
  private plots: { what: Measure; plot: uPlot }[] = [];
  private readonly still = new Map<Measure, string | null>(); // straight lines that are drawn
  private newest_s = 0; // 0 of the axis
  private shown: Window = { from_s: 0, to_s: 0 };

  constructor(
    private readonly place: HTMLElement,
    private readonly arms: number,
    private readonly listener: PlotsListener,
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

  get window(): Window {
    return this.shown;
  }
  // Of the value that the cursor is at, in the columns of what is shown.
  get cursor(): number | null {
    return this.plots[0].plot.cursor.idx ?? null;
  }

  // The curves up to a time of the history, or what is zoomed into; time 0 of the axis is the newest there is.
  update(history: History, until_s: number, newest_s: number): void {
    this.newest_s = newest_s;
    this.shown = this.zoomed ?? { from_s: until_s - this.span_s, to_s: until_s };
    const { from_s, to_s } = this.shown;
    for (const { what, plot } of this.plots) {
      const columns = history.columns(what, this.arms, from_s, to_s);
      columns[0] = columns[0].map((time) => (time as number) - newest_s);
      const still = still_key(columns, from_s - newest_s, to_s - newest_s);
      if (still !== null && still === this.still.get(what)) continue;
      this.still.set(what, still);
      plot.batch(() => {
        plot.setData(columns as uPlot.AlignedData, false);
        plot.setScale('x', { min: from_s - newest_s, max: to_s - newest_s });
        plot.setScale('y', range_of(columns.slice(1), kLeast[what]));
      });
    }
  }

  // Of what is shown, about the cursor or else the middle: half or twice the time, for example.
  zoom(factor: number): void {
    const { from_s, to_s } = this.zoomed ?? this.shown; // two presses between two frames are two
    const at_s = this.cursor_s() ?? (from_s + to_s) / 2;
    if ((to_s - from_s) * factor < kLeastSpan_s) return;
    this.listener.on_zoom({ from_s: at_s - (at_s - from_s) * factor, to_s: at_s + (to_s - at_s) * factor });
  }

  // By a share of the width; from the right edge where there was no cursor.
  move_cursor(share: number): void {
    for (const { plot } of this.plots) {
      const width = plot.over.clientWidth;
      const left = plot.cursor.left !== undefined && plot.cursor.left >= 0 ? plot.cursor.left : width;
      plot.setCursor({ left: Math.min(Math.max(left + share * width, 0), width), top: plot.over.clientHeight / 2 }, false);
    }
    this.listener.on_cursor(this.cursor);
  }

  // Colours come from the style sheet, so that they follow light and dark.
  redraw(): void {
    for (const { plot } of this.plots) plot.redraw();
  }

  private cursor_s(): number | null {
    const { plot } = this.plots[0];
    const { left } = plot.cursor;
    return left === undefined || left < 0 ? null : plot.posToVal(left, 'x') + this.newest_s;
  }

  private select(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < kLeastDrag_px) return;
    const [from_s, to_s] = [left, left + width].map((at) => plot.posToVal(at, 'x') + this.newest_s);
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (to_s - from_s >= kLeastSpan_s) this.listener.on_zoom({ from_s, to_s });
  }

  // One cursor for all curves; a drag across one selects a time.
  private cursor_options(): uPlot.Cursor {
    const moves = { pub: (type: string) => type === 'mousemove' || type === 'mouseleave', sub: () => true };
    return {
      y: false,
      drag: { x: true, y: false, setScale: false },
      sync: { key: 'curves', filters: moves },
      points: { size: 6 },
      bind: { dblclick: () => () => (this.listener.on_live(), null) },
    };
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
        cursor: this.cursor_options(),
        hooks: { setSelect: [(plot) => this.select(plot)], setCursor: [() => this.listener.on_cursor(this.cursor)] },
        padding: [6, 8, 0, 0],
        scales: { x: { time: false }, y: { auto: false, range: (_, min, max) => [min, max] } },
        axes: [
          { ...axis, size: 20, values: (_, ticks) => ticks.map((tick) => `${Number(tick.toFixed(3))} s`) },
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
