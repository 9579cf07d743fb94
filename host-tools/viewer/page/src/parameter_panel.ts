// The controller's parameters that may be written; a value lasts until power-off.
import { make } from './dom';
import type { PageMessage, Parameter } from './protocol';

export class ParameterPanel {
  private readonly inputs = new Map<string, HTMLInputElement>();

  constructor(
    private readonly place: HTMLElement,
    private readonly send: (message: PageMessage) => void,
  ) {}

  enable(yes: boolean): void {
    for (const input of this.inputs.values()) input.disabled = !yes;
  }

  // The server sends all of them after a change; a field that the user is editing is not touched.
  show(parameters: Parameter[]): void {
    const writable = parameters.filter((parameter) => parameter.writable);
    if (writable.map((it) => it.name).join() !== [...this.inputs.keys()].join()) {
      this.inputs.clear();
      this.place.replaceChildren(...writable.map((parameter) => this.row(parameter)));
    }
    for (const { name, value } of writable) {
      const input = this.inputs.get(name);
      if (input && document.activeElement !== input) input.value = `${Number(value.toPrecision(6))}`;
    }
    (this.place.parentElement as HTMLElement).hidden = writable.length === 0;
  }

  private row(parameter: Parameter): HTMLElement {
    const id = `parameter-${parameter.name}`;
    const input = make('input', { id, type: 'number', step: 'any', min: `${parameter.min}`, max: `${parameter.max}` }, { testid: id });
    input.addEventListener('change', () => {
      if (input.value === '' || !input.reportValidity()) return;
      this.send({ type: 'parameter', name: parameter.name, value: input.valueAsNumber });
    });
    this.inputs.set(parameter.name, input);
    const row = make('div', { className: 'parameter', title: parameter.text });
    const unit = make('span', { className: 'muted small', textContent: parameter.unit });
    row.append(make('label', { htmlFor: id, textContent: parameter.name }), input, unit);
    return row;
  }
}
