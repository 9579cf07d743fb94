// Sliders for the material of one object of the running scene, and the button that writes them into the scene file.
import { make } from './dom';
import type { Material, MaterialKey, PageMessage, SceneStarted } from './protocol';

interface Row {
  key: MaterialKey;
  label: string;
  most: number;
  step: number;
  least: number;
}

// Values that arms render stably; a slider reaches further if the scene's value does.
const kRows: Row[] = [
  { key: 'stiffness', label: 'Stiffness, N/m', least: 10, most: 3000, step: 10 },
  { key: 'damping', label: 'Damping, N s/m', least: 0, most: 20, step: 0.1 },
  { key: 'static_friction', label: 'Static friction', least: 0, most: 2, step: 0.01 },
  { key: 'dynamic_friction', label: 'Dynamic friction', least: 0, most: 2, step: 0.01 },
];

const kSettled_ms = 1000;

export class MaterialPanel {
  private objects: SceneStarted['objects'] = [];
  private crc: number | null = null;
  private chosen = 0;
  private readonly select = make('select', { id: 'object' }, { testid: 'object' });
  private readonly save = make('button', { type: 'button', textContent: 'Save to the scene file' }, { testid: 'save' });
  private readonly inputs = new Map<MaterialKey, { slider: HTMLInputElement; number: HTMLInputElement }>();
  private readonly unsent = new Map<MaterialKey, number>();
  private changed_ms = -Infinity;

  constructor(
    place: HTMLElement,
    private readonly send: (message: PageMessage) => void,
  ) {
    this.select.setAttribute('aria-label', 'Object');
    this.select.addEventListener('change', () => this.choose(this.select.selectedIndex));
    this.save.addEventListener('click', () => {
      this.flush();
      this.send({ type: 'save' });
    });
    place.append(this.select, ...kRows.map((row) => this.row(row)), this.save);
    this.enable(false);
  }

  enable(yes: boolean): void {
    this.save.disabled = !yes;
    for (const { slider, number } of this.inputs.values()) slider.disabled = number.disabled = !yes;
  }

  // A new running scene; the same one with other materials keeps the selected object.
  show(scene: SceneStarted): void {
    const names = scene.objects.map((object) => object.name);
    const same = names.join('\n') === this.objects.map((object) => object.name).join('\n');
    if (!same) {
      this.unsent.clear();
      this.select.replaceChildren(...names.map((name) => make('option', { textContent: name })));
      this.chosen = 0;
    }
    // While a slider is held its value is newer than that of the server. But a scene that is sent again unchanged
    // means that the change was refused.
    const refused = scene.crc === this.crc;
    this.crc = scene.crc;
    if (refused) this.unsent.clear();
    const own = same && !refused && performance.now() - this.changed_ms < kSettled_ms ? this.objects[this.chosen] : undefined;
    this.objects = scene.objects.map((object) => ({ name: object.name, material: { ...object.material } }));
    if (own !== undefined) this.objects[this.chosen] = own;
    this.choose(Math.min(this.chosen, this.objects.length - 1));
  }

  // Once a frame: a slider gives many values between two frames, and the last one counts.
  flush(): void {
    for (const [key, value] of this.unsent) this.send({ type: 'material', object: this.chosen, key, value });
    this.unsent.clear();
  }

  private choose(index: number): void {
    this.flush();
    this.chosen = Math.max(index, 0);
    this.select.selectedIndex = this.chosen;
    const material = this.objects[this.chosen]?.material;
    if (material === undefined) return;
    for (const row of kRows) this.write(row, material[row.key]);
  }

  private row(row: Row): HTMLElement {
    const id = `material-${row.key}`;
    const box = make('div', { className: 'slider' });
    const label = make('label', { textContent: row.label, htmlFor: id });
    const slider = make('input', { id, type: 'range', min: `${row.least}`, max: `${row.most}`, step: `${row.step}` }, { testid: id });
    const number = make('input', { type: 'number', min: `${row.least}`, step: 'any' }, { testid: `${id}-value` });
    number.setAttribute('aria-label', `${row.label}, as a number`);
    slider.addEventListener('input', () => this.change(row, slider.valueAsNumber));
    number.addEventListener('change', () => this.change(row, number.valueAsNumber));
    this.inputs.set(row.key, { slider, number });
    box.append(label, slider, number);
    return box;
  }

  private change(row: Row, value: number): void {
    const material = this.objects[this.chosen]?.material;
    if (material === undefined) return;
    if (!Number.isFinite(value) || value < 0) {
      this.write(row, material[row.key]);
      return;
    }
    this.changed_ms = performance.now();
    this.put(row, material, value);
    // The dynamic coefficient is at most the static one, and whoever moves one of them means that one. What is lowered goes first.
    if (row.key === 'static_friction' && material.dynamic_friction > value) {
      this.unsent.delete('static_friction');
      this.put(kRows[3], material, value);
      this.unsent.set('static_friction', value);
    }
    if (row.key === 'dynamic_friction' && material.static_friction < value) {
      this.unsent.delete('dynamic_friction');
      this.put(kRows[2], material, value);
      this.unsent.set('dynamic_friction', value);
    }
  }

  private put(row: Row, material: Material, value: number): void {
    material[row.key] = value;
    this.write(row, value);
    this.unsent.set(row.key, value);
  }

  private write(row: Row, value: number): void {
    const { slider, number } = this.inputs.get(row.key) as { slider: HTMLInputElement; number: HTMLInputElement };
    slider.max = `${Math.max(row.most, value)}`;
    slider.value = `${value}`;
    number.value = `${Number(value.toPrecision(4))}`;
  }
}
