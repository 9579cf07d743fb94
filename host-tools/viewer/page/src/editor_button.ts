// The button that opens the editor, whose code is loaded then, and files that are dropped on the page.
import { element } from './dom';
import type { Editor, EditorHost } from './editor/editor';
import { Keeper } from './editor/kept_edits';
import type { SceneStarted, ServerMessage } from './protocol';
import type { SceneObjects } from './scene_objects';

export class EditorButton {
  editor: Editor | null = null; // while it is open
  private readonly button = element<HTMLButtonElement>('edit');
  private opening: Promise<Editor> | null = null;
  private scene: SceneStarted | null = null;
  private objects: SceneObjects | null = null;
  private may_change = false;
  private readonly keeper: Keeper;
  private readonly host: EditorHost;

  constructor(
    host: Omit<EditorHost, 'keeper' | 'close'>,
    private readonly changed: () => void, // opened or closed
  ) {
    this.keeper = new Keeper(host.say);
    this.host = { ...host, keeper: this.keeper, close: () => this.close() };
    this.button.addEventListener('click', () => {
      if (this.editor === null) this.with_editor((editor) => editor.focus());
      else this.close();
    });
    document.addEventListener('dragover', (event) => event.preventDefault());
    document.addEventListener('drop', (event) => {
      event.preventDefault();
      const files = [...(event.dataTransfer?.files ?? [])];
      if (files.length > 0 && !this.button.disabled) this.with_editor((editor) => editor.drop(files));
    });
  }

  enable(may_change: boolean): void {
    this.may_change = may_change;
    this.button.disabled = this.editor === null && (!may_change || this.scene?.text_crc === undefined);
  }

  on_message(message: ServerMessage): void {
    if (this.editor !== null) this.editor.on_message(message);
    else if (message.type === 'text' && message.unsaved) void this.keeper.keep(this.scene?.pick ?? '', message.text);
  }
  // True: it is the scene that is edited, in another state.
  on_scene(scene: SceneStarted): boolean {
    const edited = this.editor !== null && this.scene?.pick === scene.pick;
    if (this.scene?.pick !== scene.pick) this.keeper.begin_anew();
    this.scene = scene;
    if (this.editor !== null) this.editor.on_scene(scene);
    else if (!scene.unsaved) void this.keeper.keep(scene.pick ?? '', null);
    else if (this.may_change) this.host.send({ type: 'text' }); // what the sliders of materials have changed is kept too
    return edited;
  }
  // Before another scene is asked for. False: the user is asked first.
  may_leave(again: () => void): boolean {
    return this.keeper.may_leave(again);
  }
  // It was asked for. Another one is another one when it comes.
  on_pick(scene: string): void {
    if (scene !== this.scene?.pick) return;
    this.keeper.begin_anew();
    this.editor?.on_reload();
  }
  show(objects: SceneObjects | null): void {
    this.objects = objects;
    this.editor?.show(objects);
  }

  private with_editor(act: (editor: Editor) => void | Promise<void>): void {
    this.opening ??= this.load();
    this.opening.then(act).catch((error: unknown) => {
      if (this.editor === null) this.opening = null; // the next time perhaps
      const cause = error instanceof Error ? error.message : String(error);
      this.host.say({ type: 'event', level: 'error', name: 'no-editor', cause, remedy: 'try again, or load the page again' });
    });
  }
  private async load(): Promise<Editor> {
    const { Editor: Loaded } = await import('./editor/editor');
    const editor = (this.editor = new Loaded(this.host));
    if (this.scene) editor.on_scene(this.scene);
    editor.show(this.objects);
    this.tell();
    return editor;
  }
  private close(): void {
    if (this.editor?.is_ahead) {
      if (!this.may_leave(() => this.close())) return; // a text that does not run goes with the editor
      this.keeper.begin_anew();
    }
    this.editor?.close();
    this.editor = this.opening = null;
    this.tell();
    this.button.focus({ preventScroll: true });
  }
  private tell(): void {
    this.button.setAttribute('aria-expanded', String(this.editor !== null));
    document.body.classList.toggle('editing', this.editor !== null);
    this.changed();
  }
}
