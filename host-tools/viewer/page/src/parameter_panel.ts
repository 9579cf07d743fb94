// The controller's parameters that may be written; a value lasts until power-off.
import { make } from './dom';
import type { PageMessage, Parameter } from './protocol';

export function show_parameters(place: HTMLElement, parameters: Parameter[], may_control: boolean, send: (it: PageMessage) => void): void {
  place.replaceChildren(
    ...parameters
      .filter((parameter) => parameter.writable)
      .map((parameter) => {
        const id = `parameter-${parameter.name}`;
        const input = make('input', {
          id,
          type: 'number',
          step: 'any',
          min: `${parameter.min}`,
          max: `${parameter.max}`,
          value: `${Number(parameter.value.toPrecision(6))}`,
          disabled: !may_control,
        }, { testid: id });
        input.addEventListener('change', () => {
          if (input.value !== '' && input.reportValidity()) send({ type: 'parameter', name: parameter.name, value: input.valueAsNumber });
        });
        const row = make('div', { className: 'parameter', title: parameter.text });
        row.append(
          make('label', { htmlFor: id, textContent: parameter.name }),
          input,
          make('span', { className: 'muted small', textContent: parameter.unit }),
        );
        return row;
      }),
  );
}
