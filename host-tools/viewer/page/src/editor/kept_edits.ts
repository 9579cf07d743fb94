// Edits that are not saved, kept in this browser (IndexedDB) until they are. Each time that a scene is edited has a key of its own, so no text replaces
// another one. Where the browser refuses storage, the page works without and asks before it gives edits up.
import { createStore, del, entries, set } from 'idb-keyval';

import { not_kept } from '../not_kept';
import { ask, forget_question } from '../question';
import type { ServerEvent } from '../protocol';

export interface KeptEdits {
  scene: string; // under which it is picked
  when_ms: number;
  text: string;
}

const kStore = createStore('thimble-edits', 'edits');
const new_key = (): string => `${Date.now()}-${Math.random()}`;

// A key that is in use has a lock of this name, which other tabs see. Without Web Locks (over http from another machine) they take it for an old one.
const lock_of = (key: string): string => `thimble-edits:${key}`;
function hold(key: string): () => void {
  let let_go = (): void => {};
  const over = new Promise<void>((done) => (let_go = done));
  void navigator.locks?.request(lock_of(key), () => over).catch(() => {});
  return let_go;
}
async function held(): Promise<Set<string | undefined>> {
  const found = await navigator.locks?.query();
  return new Set(found?.held?.map(({ name }) => name));
}

export class Keeper {
  private key = new_key();
  private let_go: (() => void) | null = null; // of the key, once something is kept under it
  private readonly former = new Set<string>(); // keys of this page
  private scene = '';
  private unsaved: string | null = null;
  private stored: string | null = null;
  private refused = false; // the last time
  private given_up = false; // the user has just said so

  constructor(private readonly say: (event: ServerEvent) => void) {
    addEventListener('beforeunload', (event) => {
      if (this.unsaved !== null && this.unsaved !== this.stored) event.preventDefault();
    });
  }

  // text: of this scene, as it is now; null: as it is saved.
  async keep(scene: string, text: string | null): Promise<void> {
    if (text === this.unsaved) return;
    const { key } = this;
    this.scene = scene;
    this.unsaved = text;
    if (text !== null) this.let_go ??= hold(key);
    try {
      await (text === null ? del(key, kStore) : set(key, { scene, when_ms: Date.now(), text }, kStore));
      if (key === this.key) this.stored = text;
      if (text !== null) this.refused = false;
    } catch (error) {
      if (text === null) return; // at worst, an older text stays among those that are listed
      if (!this.refused) this.say(not_kept('the edits that are not saved', error, 'save or download the scene before you leave it'));
      this.refused = true;
    }
  }

  // Before another scene comes. False: the user is asked, since this would give edits up; and then, perhaps, `again` is called.
  may_leave(again: () => void): boolean {
    if (this.unsaved === null || this.given_up) return true;
    if (this.refused) {
      const words = `The edits of "${this.scene}" are not saved, and this browser does not keep them. Give them up?`;
      ask(words, 'Give them up', () => this.give_up(again));
      return false;
    }
    this.say({
      type: 'event',
      level: 'info',
      name: 'edits-kept',
      cause: `the edits of "${this.scene}" are not saved; this browser keeps them`,
      remedy: 'load the scene and open the editor to restore them',
    });
    return true;
  }

  private give_up(then: () => void): void {
    this.given_up = true;
    then();
    this.given_up = false;
  }

  // What is kept now stays, and is among the others.
  begin_anew(): void {
    forget_question();
    this.let_go?.();
    this.let_go = null;
    this.former.add(this.key);
    this.key = new_key();
    this.unsaved = this.stored = null;
  }

  // Of earlier times, by their keys, the newest first. Not those that another tab has in its editor.
  async others(): Promise<[string, KeptEdits][]> {
    try {
      const [all, in_use] = await Promise.all([entries<string, KeptEdits>(kStore), held()]);
      const is_free = (key: string): boolean => this.former.has(key) || !in_use.has(lock_of(key));
      return all.filter(([key]) => key !== this.key && is_free(key)).sort(([, a], [, b]) => b.when_ms - a.when_ms);
    } catch {
      return [];
    }
  }
  async forget(key: string): Promise<void> {
    await del(key, kStore);
  }
}
