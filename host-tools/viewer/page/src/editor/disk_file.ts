// The file on the user's disk that the text is saved to, with its buttons; where the browser has none, the page's server writes the scene's file.
import { set_text } from '../dom';
import type { ServerEvent } from '../protocol';
import type { Conflict } from './conflict';
import { button } from './controls';
import { SceneFile } from './scene_file';

export interface DiskFileHost {
  text(): string;
  suggested_name(): string;
  replace(text: string): void; // the file's comes in place of what is here
  say(event: ServerEvent): void;
  changed(): void; // which file it is, or what it has
}

export class DiskFile {
  readonly save_as = button('Save as…', 'editor-save-as', () => void this.write(true));
  readonly save = button('Save to a file…', 'editor-save-file', () => void this.write());
  private readonly file = new SceneFile();

  constructor(
    private readonly host: DiskFileHost,
    private readonly conflict: Conflict,
  ) {}

  get name(): string | null {
    return this.file.name;
  }
  has(text: string): boolean {
    return this.file.has(text);
  }
  take(handle: FileSystemFileHandle, text: string): void {
    this.file.take(handle, text);
    this.host.changed();
  }
  forget(): void {
    this.file.forget();
  }
  show(): void {
    set_text(this.save, this.name === null ? 'Save to a file…' : `Save to ${this.name}`);
    this.save_as.hidden = this.name === null;
  }

  // as: the user says which.
  async write(as = false, replaces = false): Promise<void> {
    const text = this.host.text();
    await this.attempt(async () => {
      const { name } = this.file;
      if (as || name === null) return this.file.save_as(text, this.host.suggested_name());
      if (await this.file.save(text, replaces)) return;
      const why = `${name} has been changed by another program.`;
      const replace = (): void => void this.write(false, true);
      this.conflict.ask(why, () => void this.attempt(() => this.read()), replace);
    });
  }
  private async read(): Promise<void> {
    const text = await this.file.read();
    if (text !== null) this.host.replace(text);
  }
  private async attempt(work: () => Promise<void>): Promise<void> {
    try {
      await work();
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      this.host.say({ type: 'event', level: 'error', name: 'not-saved', cause, remedy: 'choose another file, or copy the text' });
    }
    this.host.changed();
  }
}
