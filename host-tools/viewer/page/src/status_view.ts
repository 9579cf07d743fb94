// The state of the controller in words: mode, fault, limiter, rates, and the readings of each arm.
import { element, make, set_text } from './dom';
import { inside_text, kMeasures, measure_text } from './measures';
import type { State } from './protocol';

const kLabels = { force: 'Force', depth: 'Depth', velocity: 'Speed', energy: 'Energy to the hand' };

export class StatusView {
  private cells: { what: (typeof kMeasures)[number] | 'contacts'; arm: number; cell: HTMLElement }[] = [];
  private announced = '';

  // Lays the table of readings out; the first arm's cells have the plain names.
  lay_out(arms: number): void {
    this.cells = [];
    const table = element('readings');
    const head = make('tr');
    head.append(make('th'), ...Array.from({ length: arms }, (_, arm) => column(`arm ${arm}`)));
    const thead = make('thead');
    if (arms > 1) thead.append(head);
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
  update_readings(state: State, names: readonly string[]): void {
    set_text(element('inside'), inside_text(state, names));
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
    set_text(
      element('limiter'),
      known(state.limiters, (names) => names.join(', ') || 'none'),
    );
    set_text(
      element('tick-rate'),
      known(state.tick_rate_Hz, (rate) => `${Math.round(rate)} Hz`),
    );
    set_text(
      element('worst-tick'),
      known(state.worst_tick_s, (time_s) => `${(time_s * 1e6).toFixed(1)} µs`),
    );
  }

  // For screen readers: only changes of mode and fault.
  announce(state: State): void {
    const why = state.stopped_by_text === undefined ? '' : ` ${state.stopped_by_text}.`;
    const text = `Mode ${state.mode ?? 'unknown'}.${why} ${state.fault ? `Fault ${state.fault_name ?? state.fault}` : 'No fault'}.`;
    if (text === this.announced) return;
    this.announced = text;
    set_text(element('announce'), text);
  }
}

const put_off_text = ({ put_off }: State, names: readonly string[]): string =>
  put_off === undefined ? '' : `${put_off.ticks} ticks put off, at ${names[put_off.object] ?? 'no object'}`;
const known = <Value>(value: Value | undefined, text: (value: Value) => string): string => (value === undefined ? '-' : text(value));
const column = (text: string): HTMLElement => make('th', { textContent: text, scope: 'col' });
