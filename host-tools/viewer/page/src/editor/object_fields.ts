// The list of objects, and the selected one's name, pose, size and material, as fields for the keyboard.
import { make } from '../dom';
import { type NumberField, NumberFields, button, choose, group, labelled } from './controls';
import type { Edit } from './json_edits';
import * as edits from './scene_edits';
import type { Outline, OutlinedObject } from './scene_outline';

export interface FieldsListener {
  selected(object: number | null): void;
  edit(make_edits: (text: string) => Edit[]): void;
}

const kMaterial: { key: string; label: string; step: number; usual: number }[] = [
  { key: 'stiffness_N_m', label: 'Stiffness, N/m', step: 10, usual: 0 },
  { key: 'damping_N_s_m', label: 'Damping, N s/m', step: 0.1, usual: 0 },
  { key: 'static_friction', label: 'Static friction', step: 0.05, usual: 0 },
  { key: 'dynamic_friction', label: 'Dynamic friction', step: 0.05, usual: 0 },
];
const kOwn = '';
const kMilli = 1000;

export class ObjectFields {
  readonly list = make('select', { size: 6 }, { testid: 'editor-objects' });
  readonly place = make('div', { className: 'object' });
  private readonly name = make('input', { type: 'text', maxLength: 64 }, { testid: 'editor-name' });
  private readonly pose = new NumberFields();
  private readonly sizes = new NumberFields();
  private readonly material = make('select', {}, { testid: 'editor-material' });
  private readonly material_name = make('input', { type: 'text', maxLength: 64 }, { testid: 'editor-material-name' });
  private readonly values = new NumberFields();
  private readonly own: HTMLButtonElement;
  private readonly shared = make('p', { className: 'small muted' });
  private index: number | null = null;
  private grid_m: number | null = null;

  constructor(private readonly listener: FieldsListener) {
    this.list.setAttribute('aria-label', 'Objects of the scene');
    this.list.addEventListener('change', () => listener.selected(this.list.selectedIndex < 0 ? null : this.list.selectedIndex));
    this.name.addEventListener('change', () => this.change((text, index) => edits.rename(text, index, this.name.value)));
    this.material.addEventListener('change', () => {
      const { value } = this.material;
      this.change((text, index) => (value === kOwn ? edits.own_material(text, index) : edits.assign_material(text, index, value)));
    });
    this.material_name.addEventListener('change', () => {
      const name = this.material_name.value.trim();
      if (name !== '') this.change((text, index) => edits.name_material(text, index, name));
    });
    this.own = button('Own copy', 'editor-own', () => this.change((text, index) => edits.own_material(text, index)));
    this.place.append(
      labelled('Name', this.name),
      this.pose.place,
      this.sizes.place,
      group('Material', labelled('Material', this.material), labelled('its name', this.material_name), this.own),
      this.shared,
      this.values.place,
    );
  }

  set grid(grid_m: number | null) {
    this.grid_m = grid_m;
  }

  show(outline: Outline, text: string, index: number | null): void {
    this.index = index;
    choose(
      this.list,
      outline.objects.map(({ name, kind }, i) => ({ value: String(i), text: `${name} (${kind.replace('_', ' ')})` })),
      index === null ? '' : String(index),
    );
    const object = index === null ? undefined : outline.objects[index];
    this.place.hidden = object === undefined;
    if (object === undefined) return;
    if (document.activeElement !== this.name) this.name.value = object.name;
    this.pose.show(this.pose_fields(object));
    this.sizes.show(
      object.sizes.map((size, i) => ({
        label: size.label,
        testid: `editor-size-${i}`,
        step: (this.grid_m ?? 0.001) * kMilli,
        value: size.value * kMilli,
        change: (value) => this.change((now, at) => edits.resize(now, at, i, value / kMilli)),
      })),
    );
    this.show_material(outline, text, object);
  }

  private pose_fields(object: OutlinedObject): NumberField[] {
    const at = (axis: number): NumberField => ({
      label: `${'XYZ'[axis]}, mm`,
      testid: `editor-position-${axis}`,
      step: (this.grid_m ?? 0.001) * kMilli,
      value: object.position_m[axis] * kMilli,
      change: (value) => this.change((text, index) => edits.move(text, index, with_axis(object.position_m, axis, value / kMilli))),
    });
    const turned = (axis: number): NumberField => ({
      label: `${['Roll', 'Pitch', 'Yaw'][axis]}, deg`,
      testid: `editor-rotation-${axis}`,
      step: this.grid_m === null ? 1 : 15,
      value: object.rotation_deg[axis],
      change: (value) => this.change((text, index) => edits.turn(text, index, with_axis(object.rotation_deg, axis, value))),
    });
    return [0, 1, 2].map(at).concat([0, 1, 2].map(turned));
  }

  private show_material(outline: Outline, text: string, object: OutlinedObject): void {
    const names = outline.materials.map(({ name }) => ({ value: name, text: name }));
    choose(this.material, [{ value: kOwn, text: 'its own' }, ...names], object.material ?? kOwn);
    if (document.activeElement !== this.material_name) this.material_name.value = object.material ?? '';
    this.own.disabled = object.material === null;
    const others = (outline.materials.find(({ name }) => name === object.material)?.users.length ?? 1) - 1;
    this.shared.textContent = others > 0 ? `Shared with ${others} other object${others > 1 ? 's' : ''}: a change is felt in all.` : '';
    this.values.show(
      kMaterial.map(({ key, label, step, usual }) => {
        const value = edits.material_value(text, object.index, key);
        return {
          label,
          testid: `editor-${key}`,
          step,
          value: typeof value === 'number' ? value : usual,
          change: (to) => this.change((now, index) => edits.set_material(now, index, key, to)),
        };
      }),
    );
  }

  private change(make_edits: (text: string, index: number) => Edit[]): void {
    const { index } = this;
    if (index !== null) this.listener.edit((text) => make_edits(text, index));
  }
}

const with_axis = <T extends readonly number[]>(of: T, axis: number, value: number): T =>
  of.map((one, i) => (i === axis ? value : one)) as unknown as T;
