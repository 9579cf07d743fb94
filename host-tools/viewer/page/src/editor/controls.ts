// Buttons and fields of the editor.
import { make } from '../dom';

export function button(text: string, testid: string, act: () => void, title = ''): HTMLButtonElement {
  const made = make('button', { type: 'button', textContent: text, title }, { testid });
  made.addEventListener('click', act);
  return made;
}

export const group = (label: string, ...children: HTMLElement[]): HTMLElement => {
  const made = make('div', { className: 'row' });
  made.setAttribute('role', 'group');
  made.setAttribute('aria-label', label);
  made.append(...children);
  return made;
};

export function labelled(text: string, input: HTMLElement): HTMLLabelElement {
  const made = make('label', { className: 'field' });
  made.append(make('span', { textContent: text }), input);
  return made;
}

export interface NumberField {
  label: string;
  testid: string;
  step: number;
  value: number;
  change(value: number): void;
}

// Number fields that keep the focus while their values change, as long as there are the same ones.
export class NumberFields {
  readonly place = make('div', { className: 'fields' });
  private inputs: HTMLInputElement[] = [];
  private shown: NumberField[] = [];
  private key = '';

  show(fields: NumberField[]): void {
    const key = fields.map((field) => field.label).join('\n');
    this.shown = fields;
    if (key !== this.key) {
      this.key = key;
      this.inputs = fields.map((_, i) => this.input(i));
      this.place.replaceChildren(...fields.map((field, i) => labelled(field.label, this.inputs[i])));
    }
    fields.forEach((field, i) => {
      const input = this.inputs[i];
      input.dataset.testid = field.testid;
      input.step = String(field.step);
      const text = String(Number(field.value.toPrecision(9)));
      if (input.valueAsNumber !== Number(text)) input.value = text;
    });
  }

  private input(index: number): HTMLInputElement {
    const made = make('input', { type: 'number' });
    made.addEventListener('change', () => {
      const field = this.shown[index];
      if (Number.isFinite(made.valueAsNumber)) field.change(made.valueAsNumber);
      else made.value = String(field.value);
    });
    return made;
  }
}

export function choose(select: HTMLSelectElement, options: readonly { value: string; text: string }[], value: string): void {
  const same = [...select.options].map((one) => `${one.value}\t${one.text}`).join('\n');
  if (same !== options.map((one) => `${one.value}\t${one.text}`).join('\n'))
    select.replaceChildren(...options.map(({ value: of, text }) => make('option', { value: of, textContent: text })));
  select.value = value;
}

// Offers bytes as a file of the user's.
export function download(name: string, text: string): void {
  const url = URL.createObjectURL(new Blob([text], { type: 'application/json' }));
  const link = make('a', { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
