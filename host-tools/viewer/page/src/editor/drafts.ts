// The text on its way: a draft is sent when the one before was answered, so that only the newest waits. Pure; no elements.
import type { Checked, PageMessage, SceneStarted, SceneText, ServerEvent } from '../protocol';

export interface DraftListener {
  // The text of another scene, or of this one changed elsewhere.
  take_text(text: string, is_new_scene: boolean): void;
  // It was changed elsewhere, and here too.
  conflict(): void;
  checked(answer: Checked): void;
}

export class Drafts {
  private pick: string | null = null; // the scene that is edited; null: one whose text is not known
  private text: string | null = null; // as it is here
  private known_crc: number | null = null; // of the text that the other end has, as far as it is known here
  private running_crc: number | null = null; // of the text of the scene that runs
  private flying: number | null = null;
  private waiting: string | null = null;
  private save_wanted: PageMessage | null = null; // once nothing is under way
  private asked = false;
  private has_errors = false;

  constructor(
    private readonly send: (message: PageMessage) => boolean,
    private readonly listener: DraftListener,
    private number = Math.floor(Math.random() * 500_000), // of the last draft; the answers go to all pages, which tell their own by it
  ) {}

  get busy(): boolean {
    return this.flying !== null || this.waiting !== null;
  }
  get is_ready(): boolean {
    return this.text !== null;
  }
  // Whether what is here does not run, as far as the other end has told: a checked text runs only when its scene comes.
  get is_ahead(): boolean {
    return this.busy || this.has_errors || (this.text !== null && this.running_crc !== this.known_crc);
  }

  // Of a scene that runs: whether its text is not the one that is here.
  is_other_text({ text_crc }: SceneStarted): boolean {
    return text_crc !== undefined && text_crc !== this.known_crc;
  }

  ask(): void {
    this.asked = this.send({ type: 'text' });
  }

  // The text has changed here.
  submit(text: string): void {
    this.text = text;
    this.waiting = text;
    this.pump();
  }

  // What is here goes into the file, after it was checked.
  save(text: string, replaces: boolean): void {
    this.save_wanted = { type: 'save', replaces };
    this.submit(text);
  }

  // After the connection was lost: what was sent may not have come.
  restart(): void {
    if (this.flying !== null) this.waiting ??= this.text;
    this.flying = null;
    this.pump();
  }

  on_scene(scene: SceneStarted): void {
    const pick = scene.pick ?? null;
    this.running_crc = scene.text_crc ?? null;
    if (pick !== this.pick) {
      this.pick = pick;
      if (this.text !== null) ++this.number; // late answers are none
      this.text = this.waiting = this.save_wanted = null;
      this.flying = null;
      this.has_errors = false;
      if (pick !== null) this.ask();
    } else if (this.is_other_text(scene) && !this.busy && !this.asked) this.ask();
  }

  on_text(it: SceneText): void {
    this.asked = false;
    if (this.pick === null) return; // of the scene before
    const before = this.text;
    if (before !== null && (this.busy || it.crc === this.known_crc)) return;
    this.known_crc = it.crc;
    if (before !== null && this.has_errors) {
      this.listener.conflict();
      return;
    }
    this.take(it.text, before === null);
  }

  // The text of the file comes, whatever is here.
  reload(): void {
    ++this.number; // late answers are none
    this.waiting = this.flying = this.save_wanted = null;
    this.has_errors = false;
    this.known_crc = null;
  }

  on_checked(answer: Checked): void {
    // Once more where the device does not take it, or where it was another message that was refused.
    if (answer.number !== this.number || (this.flying === null && answer.issues.length === 0 && !this.has_errors)) return;
    this.flying = null;
    this.has_errors = answer.issues.length > 0;
    if (answer.crc !== undefined) this.known_crc = answer.crc;
    this.listener.checked(answer);
    this.pump();
  }

  // The other end has not taken a message, perhaps the draft that is under way.
  refuse({ name, cause, remedy }: ServerEvent): void {
    if (this.flying === null) return;
    const issue = { name, cause, remedy, pointer: '', line: 1, column: 1 };
    this.on_checked({ type: 'checked', number: this.flying, issues: [issue], more: 0 });
  }

  private take(text: string, is_new: boolean): void {
    this.text = text;
    this.has_errors = false;
    this.listener.take_text(text, is_new);
  }

  private pump(): void {
    if (this.flying !== null) return;
    if (this.waiting === null) {
      if (this.save_wanted !== null && this.send(this.save_wanted)) this.save_wanted = null;
      return;
    }
    const text = this.waiting;
    if (!this.send({ type: 'draft', number: this.number + 1, text })) return;
    this.waiting = null;
    this.flying = ++this.number;
  }
}
