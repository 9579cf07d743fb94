// A file on the user's disk that the text is saved to again and again, where the browser has the File System Access API.
interface Pickers {
  showOpenFilePicker?: (options: { multiple: boolean }) => Promise<FileSystemFileHandle[]>;
  showSaveFilePicker?: (options: { suggestedName: string }) => Promise<FileSystemFileHandle>;
}
const pickers = (): Pickers => window as Pickers;

export const can_write_files = (): boolean => pickers().showSaveFilePicker !== undefined;
export const can_open_files = (): boolean => pickers().showOpenFilePicker !== undefined;

// None: the user has given up.
export async function open_files(): Promise<FileSystemFileHandle[]> {
  return (await unless_given_up(pickers().showOpenFilePicker!({ multiple: true }))) ?? [];
}

interface Opened {
  handle: FileSystemFileHandle;
  known: string; // what it had when it was read or written last
}

export class SceneFile {
  private opened: Opened | null = null;
  private changes = 0; // of which file it is
  private writing: Promise<unknown> = Promise.resolve();

  get name(): string | null {
    return this.opened?.handle.name ?? null;
  }
  has(text: string): boolean {
    return text === this.opened?.known;
  }

  // known: its text.
  take(handle: FileSystemFileHandle, known: string): void {
    ++this.changes;
    this.opened = { handle, known };
  }
  // Another scene is here.
  forget(): void {
    ++this.changes;
    this.opened = null;
  }

  // The user says where. It is the file from then on, unless another one or another scene has come meanwhile.
  async save_as(text: string, suggestedName: string): Promise<void> {
    const { changes } = this;
    const handle = await unless_given_up(pickers().showSaveFilePicker!({ suggestedName }));
    if (handle === null) return;
    await this.in_turn(() => write(handle, text));
    if (changes === this.changes) this.take(handle, text);
  }
  // Into the file that it is now. False: another program has changed it since, and `replaces` is false.
  save(text: string, replaces: boolean): Promise<boolean> {
    const file = this.file;
    return this.in_turn(async () => {
      if (!replaces && (await text_in(file.handle)) !== file.known) return false;
      await write(file.handle, text);
      file.known = text;
      return true;
    });
  }
  // Null: it is another file by now.
  async read(): Promise<string | null> {
    const file = this.file;
    file.known = await text_in(file.handle);
    return file === this.opened ? file.known : null;
  }

  private get file(): Opened {
    if (this.opened === null) throw new Error('no file has been chosen');
    return this.opened;
  }
  // After what is being written, which would look like the change of another program.
  private in_turn<T>(work: () => Promise<T>): Promise<T> {
    const done = this.writing.then(work);
    this.writing = done.catch(() => {});
    return done;
  }
}

async function write(handle: FileSystemFileHandle, text: string): Promise<void> {
  const stream = await handle.createWritable();
  await stream.write(text);
  await stream.close();
}
const text_in = async (handle: FileSystemFileHandle): Promise<string> => (await handle.getFile()).text();

async function unless_given_up<T>(asked: Promise<T>): Promise<T | null> {
  try {
    return await asked;
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') return null;
    throw error;
  }
}
