// The editor of the scene that runs. The text is what counts: each action edits it, and what has no errors runs. Loaded when it is asked for.
import './editor.css';

import { make, set_text } from '../dom';
import type { Checked, PageMessage, SceneStarted, ServerEvent, ServerMessage } from '../protocol';
import type { SceneObjects } from '../scene_objects';
import type { Stage } from '../stage';
import type { Transport } from '../transport';
import { Conflict } from './conflict';
import { button, choose, download, group, labelled } from './controls';
import { DiskFile } from './disk_file';
import { Drafts } from './drafts';
import { Handles, type Way } from './handles';
import { Importer } from './importer';
import { IssueList } from './issue_list';
import { type Edit, NotJson, apply } from './json_edits';
import type { Keeper } from './kept_edits';
import { KeptList } from './kept_list';
import { ObjectFields } from './object_fields';
import * as edits from './scene_edits';
import { can_write_files } from './scene_file';
import { type Outline, outline_of } from './scene_outline';
import { kAddable, object_to_add } from './templates';
import { TextView } from './text_view';

export interface EditorHost {
  place: HTMLElement;
  stage: Stage | null;
  transport: Transport;
  keeper: Keeper;
  send(message: PageMessage, again?: () => void): boolean; // again: in its place, if the user has to be asked first and agrees
  say(event: ServerEvent): void;
  close(): void;
}

const kTyped_ms = 150; // after the last key the text is compiled
const is_sheet = (): boolean => matchMedia('(max-width: 820px)').matches; // as in editor.css
const kConflicts = new Set(['scene-changed', 'file-changed']);
const kRefused = new Set(['busy', 'scene-file-too-large', 'bad-message']); // messages that were not taken; a draft perhaps

export class Editor {
  private readonly text: TextView;
  private readonly drafts: Drafts;
  private readonly fields: ObjectFields;
  private readonly issues: IssueList;
  private readonly handles: Handles | null;
  private readonly importer: Importer;
  private readonly kept: KeptList;
  private readonly state = make('p', { className: 'small' }, { testid: 'editor-state' });
  private readonly conflict = new Conflict();
  private readonly file: DiskFile;
  private readonly undo = button('Undo', 'editor-undo', () => this.text.undo(), 'Ctrl+Z');
  private readonly redo = button('Redo', 'editor-redo', () => this.text.redo(), 'Ctrl+Y');
  private readonly parts = make('select', {}, { testid: 'editor-part' });
  private readonly grid = make('input', { type: 'number', min: '0.1', step: '0.5', value: '5' }, { testid: 'editor-grid' });
  private readonly snaps = make('input', { type: 'checkbox' }, { testid: 'editor-snap' });
  private outline: Outline | null = null; // of the last text that had one
  private selected: number | null = null;
  private dragged: string | null = null; // the text while a handle is held
  private scene: SceneStarted | null = null;
  private file_name = 'scene.scene.json';
  private typed: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly host: EditorHost) {
    this.fields = new ObjectFields({ selected: (object) => this.select(object, true), edit: (how) => this.edit(how) });
    this.issues = new IssueList((line, column) => this.text.reveal_line(line, column));
    this.importer = new Importer(host, {
      edit: (how) => this.edit(how),
      outline: () => this.outline,
      text: () => this.text.text,
      select_last: () => this.select_last(),
      opened: (file, text) => {
        if (this.writes_files) this.file.take(file, text);
      },
      taken: () => this.show_kept(),
    });
    this.file = new DiskFile(
      {
        text: () => this.text.text,
        suggested_name: () => this.file_name,
        replace: (text) => this.replace(text),
        say: (event) => host.say(event),
        changed: () => this.show_state(),
      },
      this.conflict,
    );
    this.kept = new KeptList(host.keeper, host.transport, {
      restore: (text) => this.replace(text),
      load: (scene) => host.send({ type: 'pick', scene }),
      removed: () => this.submit(), // the scene may name it
    });
    const text_place = make('div', { className: 'text' }, { testid: 'editor-text' });
    host.place.replaceChildren(...this.lay_out(text_place));
    this.text = new TextView(text_place, { changed: () => this.on_typed(), at: (offset) => this.select_at(offset) });
    this.drafts = new Drafts(host.send, {
      take_text: (text, is_new) => this.take_text(text, is_new),
      conflict: () => this.show_scene_conflict('The scene has been changed elsewhere, and the text here has errors.'),
      checked: (answer) => this.on_checked(answer),
    });
    this.handles = host.stage === null ? null : this.make_handles(host.stage);
    host.place.hidden = false;
    host.place.addEventListener('keydown', (event) => this.on_key(event));
  }

  // --- What the page tells

  on_message(message: ServerMessage): void {
    if (message.type === 'text') {
      this.file_name = message.file;
      this.drafts.on_text(message);
    } else if (message.type === 'checked') this.drafts.on_checked(message);
    else if (message.type === 'event' && kConflicts.has(message.name)) this.show_scene_conflict(`${message.cause}.`);
    else if (message.type === 'event' && message.name === 'saved') this.conflict.hide();
    else if (message.type === 'event' && kRefused.has(message.name)) this.drafts.refuse(message);
    else if (message.type === 'hello') this.drafts.restart();
  }
  // The scene that is here comes anew, from its file.
  on_reload(): void {
    this.stop_typing();
    this.drafts.reload();
    this.show_state();
  }
  on_scene(scene: SceneStarted): void {
    this.scene = scene;
    // It is saved, but by somebody else: what was edited here stays kept.
    if (!scene.unsaved && this.drafts.is_other_text(scene)) this.host.keeper.begin_anew();
    this.drafts.on_scene(scene);
    this.allow(scene.pick !== undefined);
    this.show_state();
  }
  // Whether the text of the scene is known.
  private allow(is_known: boolean): void {
    for (const part of this.host.place.querySelectorAll<HTMLElement>(':scope > :not(.head)')) part.inert = !is_known;
    this.kept.place.inert = false;
    if (is_known) return;
    this.stop_typing();
    this.outline = null;
    this.take_text('', true);
  }
  show(objects: SceneObjects | null): void {
    this.handles?.show(objects);
    this.importer.fit(objects);
  }
  get is_dragging(): boolean {
    return this.handles?.is_dragging ?? false;
  }
  // What is here does not run.
  get is_ahead(): boolean {
    return this.typed !== undefined || this.drafts.is_ahead;
  }
  get wants_press(): boolean {
    return this.handles?.is_wanted ?? false;
  }
  async drop(files: readonly File[]): Promise<void> {
    if (this.scene?.pick !== undefined) await this.importer.take(files);
  }
  focus(): void {
    if (is_sheet()) this.host.stage?.canvas.scrollIntoView();
    this.fields.list.focus({ preventScroll: true });
  }
  close(): void {
    this.stop_typing();
    this.handles?.destroy();
    this.text.destroy();
    this.host.place.replaceChildren();
    this.host.place.hidden = true;
  }

  // --- Edits

  private edit(how: (text: string) => Edit[]): void {
    try {
      this.text.edit(how(this.text.text));
    } catch (error) {
      if (!(error instanceof NotJson)) throw error;
      this.host.say({ type: 'event', level: 'error', name: 'no-text', cause: error.message, remedy: 'correct the text first' });
      return;
    }
    this.submit();
  }

  private stop_typing(): void {
    clearTimeout(this.typed);
    this.typed = undefined;
  }
  private on_typed(): void {
    clearTimeout(this.typed);
    this.typed = setTimeout(() => this.submit(), kTyped_ms);
    this.show_text();
  }

  private submit(): void {
    this.stop_typing();
    if (!this.drafts.is_ready) return;
    this.drafts.submit(this.text.text);
    this.show_state();
  }

  private save(replaces = false): void {
    this.stop_typing();
    if (!this.drafts.is_ready) return;
    this.drafts.save(this.text.text, replaces);
    this.show_state();
  }

  // Elsewhere the server writes the scene's file.
  private get writes_files(): boolean {
    return this.host.transport.keeps !== undefined && can_write_files();
  }
  private take_text(text: string, is_new: boolean): void {
    this.stop_typing();
    if (is_new) this.text.begin(text);
    else this.text.edit(edits.whole(this.text.text, text), true);
    this.conflict.hide();
    this.issues.show([], 0);
    this.text.show_issues([]);
    if (is_new) {
      this.selected = null;
      this.file.forget();
    }
    this.show_text();
    this.show_kept();
  }

  // By edits of an earlier time, or by the file on the disk; what is here and not saved stays kept by itself.
  private replace(text: string): void {
    this.host.keeper.begin_anew();
    this.edit((now) => edits.whole(now, text));
    this.show_kept();
  }

  private on_checked(answer: Checked): void {
    this.issues.show(answer.issues, answer.more);
    this.text.show_issues(answer.issues);
    this.show_state();
  }

  // --- Objects

  private select(object: number | null, reveal: boolean): void {
    this.selected = object;
    const found = object === null ? undefined : this.outline?.objects[object];
    if (reveal && found !== undefined) this.text.reveal(found.offset);
    this.show_text();
  }
  private select_at(offset: number): void {
    const found = this.outline?.objects.find((object) => object.offset <= offset && offset <= object.end);
    if (found !== undefined && found.index !== this.selected) this.select(found.index, false);
  }

  private with_selected(how: (text: string, object: number) => Edit[], then: (object: number) => number | null = (object) => object): void {
    const object = this.selected;
    if (object === null) return;
    this.edit((text) => how(text, object));
    this.select(then(object), true);
  }
  private duplicate(): void {
    this.with_selected(edits.duplicate, (object) => object + 1);
  }
  private remove(): void {
    this.with_selected(edits.remove, (object) => {
      const count = this.outline?.objects.length ?? 0;
      return count === 0 ? null : Math.min(object, count - 1);
    });
  }
  private add(): void {
    this.edit((text) => edits.add(text, object_to_add(this.parts.value, outline_of(text))));
    this.select_last();
  }
  private select_last(): void {
    this.select((this.outline?.objects.length ?? 0) - 1, true);
  }

  private make_handles(stage: Stage): Handles {
    return new Handles(stage, {
      picked: (object) => this.select(object, true),
      began: () => (this.dragged = this.text.text),
      dragged: (way, pose, factors) => {
        const [before, object] = [this.text.text, this.selected];
        if (object === null) return;
        if (way === 'translate') this.dragged = apply(before, edits.move(before, object, pose.position_m));
        else if (way === 'rotate') this.dragged = apply(before, edits.turn(before, object, pose.rotation_deg));
        else this.dragged = apply(before, edits.scale(before, object, factors));
        this.drafts.submit(this.dragged);
      },
      ended: () => {
        const after = this.dragged;
        this.dragged = null;
        if (after !== null) this.edit((text) => edits.whole(text, after));
      },
    });
  }

  // --- What is shown

  private show_text(): void {
    const { text } = this.text;
    this.outline = outline_of(text) ?? this.outline;
    const count = this.outline?.objects.length ?? 0;
    if (this.selected !== null && this.selected >= count) this.selected = null;
    const object = this.selected === null ? undefined : this.outline?.objects[this.selected];
    if (this.outline !== null && outline_of(text) !== null) this.fields.show(this.outline, text, this.selected);
    this.handles?.select(this.selected, object ?? null);
    this.undo.disabled = !this.text.can_undo;
    this.redo.disabled = !this.text.can_redo;
    this.show_state();
  }

  private show_state(): void {
    const { pick } = this.scene ?? {};
    const running = this.run_state();
    const in_file = this.file.has(this.text.text);
    const unsaved = !in_file && (this.scene?.unsaved || this.is_ahead);
    const saved = unsaved ? ' Not saved.' : in_file ? ` Saved to ${this.file.name}.` : '';
    set_text(this.state, pick === undefined ? 'The text of the scene that runs is not known here.' : `${running}.${saved}`);
    this.file.show();
    if (pick !== undefined && this.drafts.is_ready) void this.host.keeper.keep(pick, unsaved ? this.text.text : null);
  }

  private run_state(): string {
    if (this.typed !== undefined || this.drafts.busy) return 'Compiling';
    if (this.issues.count > 0) return 'Errors: the scene runs as it was';
    return this.is_ahead ? 'Not run yet' : 'Runs';
  }

  private show_kept(): void {
    void this.kept.show(this.scene?.pick ?? '', this.text.text);
  }

  private show_scene_conflict(why: string): void {
    const load = (): void => {
      const { pick } = this.scene ?? {};
      if (pick === undefined) this.drafts.reload();
      else this.host.send({ type: 'pick', scene: pick });
    };
    this.conflict.ask(why, load, () => this.save(true));
  }

  private on_key(event: KeyboardEvent): void {
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    const in_list = event.target === this.fields.list;
    if (command && key === 's') void (this.file.name === null ? this.save() : this.file.write());
    else if (in_list && event.key === 'Delete') this.remove();
    else if (in_list && command && key === 'd') this.duplicate();
    else if (in_list && command && key === 'z' && !event.shiftKey) this.text.undo();
    else if (in_list && command && (key === 'y' || key === 'z')) this.text.redo();
    else return;
    event.preventDefault();
  }

  private lay_out(text_place: HTMLElement): HTMLElement[] {
    choose(
      this.parts,
      kAddable.map((name) => ({ value: name, text: name })),
      kAddable[0],
    );
    this.state.setAttribute('role', 'status');
    const { restore, keeps } = this.host.transport;
    const save = button(keeps ?? 'Save to the scene file', 'editor-save', () => this.save(), 'Ctrl+S');
    const copy = button('Download', 'editor-download', () => download(this.file_name, this.text.text));
    const to_disk = this.writes_files ? [this.file.save, this.file.save_as] : [copy];
    const original = button('Original', 'editor-original', () => this.to_original(), 'The scene as it came');
    const snap = () => {
      const grid_m = this.snaps.checked && this.grid.valueAsNumber > 0 ? this.grid.valueAsNumber / 1000 : null;
      this.handles?.snap(grid_m);
      this.fields.grid = grid_m;
      this.show_text();
    };
    this.snaps.addEventListener('change', snap);
    this.grid.addEventListener('change', snap);
    const head = make('div', { className: 'row spread head' });
    head.append(
      make('h2', { textContent: 'Editor' }),
      button('Close', 'editor-close', () => this.host.close()),
    );
    return [
      head,
      group('Text', this.undo, this.redo, save, ...to_disk, ...(restore === undefined ? [] : [original])),
      this.state,
      this.conflict.place,
      this.kept.place,
      this.fields.list,
      group(
        'Add',
        labelled('Add', this.parts),
        button('Add', 'editor-add', () => this.add()),
        this.importer.button,
      ),
      group(
        'Selected object',
        button('Duplicate', 'editor-duplicate', () => this.duplicate(), 'Ctrl+D in the list'),
        button('Delete', 'editor-delete', () => this.remove(), 'Delete in the list'),
        labelled('Handles', this.ways()),
        labelled('Snap', this.snaps),
        labelled('Grid, mm', this.grid),
      ),
      this.fields.place,
      text_place,
      this.issues.place,
    ];
  }

  private ways(): HTMLSelectElement {
    const made = make('select', {}, { testid: 'editor-way' });
    const all: { value: Way; text: string }[] = [
      { value: 'translate', text: 'move' },
      { value: 'rotate', text: 'turn' },
      { value: 'scale', text: 'scale' },
    ];
    choose(made, all, 'translate');
    made.addEventListener('change', () => {
      if (this.handles) this.handles.way = made.value as Way;
    });
    return made;
  }

  private to_original(): void {
    const { pick } = this.scene ?? {};
    if (pick !== undefined && this.host.send({ type: 'pick', scene: pick }, () => this.to_original())) this.host.transport.restore?.(pick);
  }
}
