// The state of the controller in words: mode, fault, what limits the force, rates, and the readings of each arm.
import { element, make, set_text } from './dom';
import { kLimits, limits_text } from './limit_words';
import { kMeasures, measure_text } from './measures';
import type { State } from './protocol';
import type { Load } from './transport';
import type { Vec3 } from './vector';
import { inside_text } from './way_out';

const kLabels = { force: 'Force', depth: 'Depth', velocity: 'Speed', energy: 'Energy to the hand' };

export class StatusView {
  private cells: { what: (typeof kMeasures)[number] | 'contacts'; arm: number; cell: HTMLElement }[] = [];
  private announced = '';
  load: Load | null = null; // of a device in the page

  constructor() {
    for (const { short, long } of Object.values(kLimits))
      element('limit-words').append(make('dt', { textContent: short }), make('dd', { textContent: long }));
  }

  // Lays the table of readings out; the first arm's cells have the plain names.
  lay_out(arms: number): void {
    this.cells = [];
    const table = element('readings');
    const head = make('tr');
    head.append(make('td'), ...Array.from({ length: arms }, (_, arm) => column(arms > 1 ? `arm ${arm}` : 'arm')));
    const thead = make('thead');
    thead.append(head);
    const body = make('tbody');
    for (const what of [...kMeasures, 'contacts' as const]) {
      const line = make('tr');
      line.append(make('th', { textContent: what === 'contacts' ? 'Contacts' : kLabels[what], scope: 'row' }));
      for (let arm = 0; arm < arms; ++arm) {
        const cell = make('td', { textContent: '-' }, { testid: arm === 0 ? what : `${what}-${arm}` });
        this.cells.push({ what, arm, cell });
        line.append(cell);
      }
      body.append(line);
    }
    table.replaceChildren(thead, body);
  }

  // The state at the moment shown, which may be in the past. names: of the scene's objects.
  update_readings(state: State, names: readonly string[], way: (tip_m: Vec3, object: number) => Vec3 | null): void {
    set_text(element('inside'), inside_text(state, names, way));
    set_text(element('view-force'), state.arms.map((_, arm) => measure_text(state, arm, 'force')).join(' · '));
    set_text(element('put-off'), put_off_text(state, names));
    for (const { what, arm, cell } of this.cells)
      set_text(cell, what === 'contacts' ? `${state.arms[arm]?.contacts ?? '-'}` : measure_text(state, arm, what));
  }

  // Mode and fault are always the present ones, so that nobody takes a past moment for the state of the device.
  update(state: State): void {
    const faulted = (state.fault ?? 0) !== 0;
    const fault = faulted ? `${state.fault} ${state.fault_name ?? ''}` : 'none';
    set_text(element('mode'), state.mode ?? '-');
    element('mode').className = state.mode === 'armed' ? 'good' : state.mode === 'faulted' ? 'bad' : '';
    set_text(element('stopped-by'), state.stopped_by_text ?? '');
    set_text(element('fault'), fault);
    element('fault').className = faulted ? 'bad' : '';
    set_text(element('limiter'), known(state.limiters, limits_text));
    set_text(
      element('tick-rate'),
      known(state.tick_rate_Hz, (rate) => `${Math.round(rate)} Hz`),
    );
    const { load } = this;
    set_text(element('worst-tick'), load?.worst_tick_us ? long_tick_text(load.worst_tick_us) : known(state.worst_tick_s, worst_tick_text));
    set_text(element('lost-ticks'), load === null ? '' : lost_text(load, state.tick_rate_Hz ?? 0));
    set_text(element('core-load'), load === null ? '' : `load ${Math.round(100 * load.busy)} %`);
    set_old(false);
  }

  // The link is lost: the last numbers stay, and nothing of them looks as if it were now.
  update_unknown(): void {
    for (const id of ['mode', 'fault']) {
      set_text(element(id), 'unknown');
      element(id).className = '';
    }
    set_text(element('stopped-by'), '');
    set_old(true);
  }

  // For screen readers: only changes of mode and fault.
  announce(state: State): void {
    const why = state.stopped_by_text === undefined ? '' : ` ${state.stopped_by_text}.`;
    const text = `Mode ${state.mode ?? 'unknown'}.${why} ${state.fault ? `Fault ${state.fault_name ?? state.fault}` : 'No fault'}.`;
    this.tell(text);
  }

  announce_unknown(link: string): void {
    this.tell(`Link ${link}. Mode unknown: all readings are old.`);
  }

  private tell(text: string): void {
    if (text === this.announced) return;
    this.announced = text;
    set_text(element('announce'), text);
  }
}

const us_text = (time_us: number): string => `${time_us.toFixed(1)} µs`;
// The device's number ends here: 16 bits of 0.1 us.
const kMostTick_s = 6553.5e-6;
export const worst_tick_text = (time_s: number): string => (time_s > kMostTick_s - 1e-8 ? '> 6.5 ms' : us_text(time_s * 1e6));
export const long_tick_text = (time_us: number): string => (time_us < 1000 ? us_text(time_us) : `${(time_us / 1000).toFixed(1)} ms`);
export const lost_text = ({ lost_s }: Load, rate_Hz: number): string => `${Math.round(lost_s * rate_Hz)} lost`;

function set_old(yes: boolean): void {
  document.body.classList.toggle('stale', yes);
  element('readings').setAttribute('aria-label', yes ? 'Readings, old' : 'Readings');
}

const put_off_text = ({ put_off }: State, names: readonly string[]): string =>
  put_off === undefined ? '' : `${put_off.ticks} ticks put off, at ${names[put_off.object] ?? 'no object'}`;
const known = <Value>(value: Value | undefined, text: (value: Value) => string): string => (value === undefined ? '-' : text(value));
const column = (text: string): HTMLElement => make('th', { textContent: text, scope: 'col' });
