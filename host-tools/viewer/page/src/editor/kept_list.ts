// What this browser keeps: edits that were not saved, and files that were added. Each can be taken away.
import { make } from '../dom';
import type { OwnFile, Transport } from '../transport';
import { button, download } from './controls';
import type { Keeper, KeptEdits } from './kept_edits';

export interface KeptListener {
  restore(text: string): void; // edits of the scene that is here
  load(scene: string): void; // another one, that has edits
  removed(): void; // a file
}

export class KeptList {
  readonly place = make('section', { className: 'kept', hidden: true }, { testid: 'editor-kept' });
  private shown = 0; // the last time

  constructor(
    private readonly keeper: Keeper,
    private readonly transport: Pick<Transport, 'own_files' | 'scenes'>,
    private readonly listener: KeptListener,
  ) {
    this.place.setAttribute('aria-label', 'Kept in this browser');
  }

  // text: what is here of the scene. Edits that are the same, or the same as newer ones, are forgotten.
  async show(scene: string, text: string): Promise<void> {
    const turn = ++this.shown;
    const again = (): Promise<void> => this.show(scene, text);
    const seen = new Set([text_of({ scene, text })]);
    const items: HTMLElement[] = [];
    const others = await this.keeper.others();
    const scenes = others.length > 0 ? await this.transport.scenes().catch(() => []) : [];
    for (const [key, edits] of others) {
      if (seen.has(text_of(edits))) void this.keeper.forget(key);
      else items.push(this.edits_item(key, edits, this.way_to(edits, scene, scenes), again));
      seen.add(text_of(edits));
    }
    if (turn !== this.shown) return;
    for (const file of this.transport.own_files?.all ?? []) items.push(this.file_item(file, again));
    const list = make('ul');
    list.append(...items);
    this.place.replaceChildren(make('h3', { textContent: 'Kept in this browser' }), list);
    this.place.hidden = items.length === 0;
  }

  // A scene that came by a link, say, is not among those to load.
  private way_to({ scene, text }: KeptEdits, here: string, scenes: string[]): HTMLButtonElement {
    if (scene === here) return button('Restore', 'editor-restore', () => this.listener.restore(text));
    if (scenes.includes(scene)) return button('Load', 'editor-load-kept', () => this.listener.load(scene));
    return button('Download', 'editor-download-kept', () => download(`${scene}.scene.json`, text));
  }
  private edits_item(key: string, { scene, when_ms }: KeptEdits, way: HTMLButtonElement, then: () => void): HTMLElement {
    return item(
      `Edits of “${scene}”, not saved, ${new Date(when_ms).toLocaleString()}`,
      way,
      button('Delete', 'editor-delete-edits', () => void this.keeper.forget(key).then(then)),
    );
  }
  private file_item({ path, size }: OwnFile, then: () => void): HTMLElement {
    const remove = button('Remove', 'editor-remove-file', () => void this.remove(path).then(then));
    return item(`File ${path.replace('/scenes/', '')}, ${Math.ceil(size / 1024)} KiB`, remove);
  }

  private async remove(path: string): Promise<void> {
    await this.transport.own_files?.remove(path);
    this.listener.removed();
  }
}

const text_of = ({ scene, text }: { scene: string; text: string }): string => `${scene}\n${text}`;

function item(text: string, ...buttons: HTMLButtonElement[]): HTMLLIElement {
  const made = make('li');
  for (const one of buttons) one.setAttribute('aria-label', `${one.textContent}: ${text}`);
  made.append(make('span', { textContent: text }), ...buttons);
  return made;
}
