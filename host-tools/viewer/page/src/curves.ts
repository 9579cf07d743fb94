// The panel of the curves: which part of the time they show, the values under the cursor, and the buttons and keys for both.
import './curves.css';

import { csv_of, download, values_text } from './curve_table';
import { element, set_text } from './dom';
import { Plots, type Window } from './plots';
import type { Timeline } from './timeline';

const kZoom = 2;
const kCursorStep = 0.01; // of the width; with shift ten times
const kHint = 'Point at a curve to read it, drag across it to zoom. Keys: arrows, + and -, L for live.';

export class Curves {
  private plots: Plots | null = null;
  private arms = 1;
  private told: number | null = null; // what the cursor is at

  // on_change: the timeline has been paused, or goes on.
  constructor(
    private readonly timeline: Timeline,
    private readonly on_change: () => void,
  ) {
    const span = element<HTMLSelectElement>('span');
    span.addEventListener('change', () => {
      if (this.plots === null) return;
      this.plots.span_s = Number(span.value);
      this.forget_zoom();
      this.on_change();
    });
    element('curves-in').addEventListener('click', () => this.plots?.zoom(1 / kZoom));
    element('curves-out').addEventListener('click', () => this.plots?.zoom(kZoom));
    element('curves-live').addEventListener('click', () => this.go_live());
    element('curves-export').addEventListener('click', () => this.save());
    element('plots').addEventListener('keydown', (event) => this.on_key(event));
  }

  lay_out(arms: number): void {
    this.plots?.dispose();
    this.arms = arms;
    this.plots = new Plots(element('plots'), arms, {
      on_zoom: (window) => this.show(window),
      on_live: () => this.go_live(),
      on_cursor: (index) => {
        this.told = index;
        this.tell();
      },
    });
    this.plots.span_s = Number(element<HTMLSelectElement>('span').value);
    this.tell();
  }

  update(): void {
    this.plots?.update(this.timeline.shown, this.timeline.until_s, this.timeline.newest_s);
    this.tell();
  }

  redraw(): void {
    this.plots?.redraw();
  }

  // The timeline shows another time, so the curves do.
  forget_zoom(): void {
    if (this.plots) this.plots.zoomed = null;
  }

  // Zoomed curves stand still: the timeline is paused.
  private show(window: Window): void {
    if (this.plots === null || this.timeline.live.size === 0) return;
    this.timeline.pause();
    this.plots.zoomed = window;
    this.on_change();
  }

  private go_live(): void {
    this.forget_zoom();
    this.timeline.resume();
    this.on_change();
  }

  private tell(): void {
    const { timeline, plots, told } = this;
    const text = plots && told !== null ? values_text(timeline.shown, this.arms, plots.window, timeline.newest_s, told) : '';
    set_text(element('curve-values'), text || kHint);
  }

  private save(): void {
    if (this.plots) download(csv_of(this.timeline.shown, this.arms, this.plots.window), 'thimble-curves.csv');
  }

  private on_key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = kCursorStep * (event.shiftKey ? 10 : 1);
    const keys: Record<string, () => void> = {
      ArrowLeft: () => this.plots?.move_cursor(-step),
      ArrowRight: () => this.plots?.move_cursor(step),
      '+': () => this.plots?.zoom(1 / kZoom),
      '-': () => this.plots?.zoom(kZoom),
      l: () => this.go_live(),
      L: () => this.go_live(),
    };
    if (keys[event.key] === undefined) return;
    event.preventDefault();
    keys[event.key]();
  }
}
