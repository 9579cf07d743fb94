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

export class SceneFile {
  private handle: FileSystemFileHandle | null = null;
  private known: string | null = null; // what it had when it was read or written last; null: it is to be replaced whatever it has

  get name(): string | null {
    return this.handle?.name ?? null;
  }
  has(text: string): boolean {
    return this.handle !== null && text === this.known;
  }

  // known: its text.
  take(handle: FileSystemFileHandle | null, known: string | null): void {
    this.handle = handle;
    this.known = known;
  }
  // The user says where. False: and has given up.
  async choose(suggestedName: string): Promise<boolean> {
    const handle = await unless_given_up(pickers().showSaveFilePicker!({ suggestedName }));
    if (handle !== null) this.take(handle, null);
    return handle !== null;
  }

  // False: another program has changed it since, and `replaces` is false.
  async save(text: string, replaces: boolean): Promise<boolean> {
    if (this.handle === null) throw new Error('no file has been chosen');
    if (!replaces && this.known !== null && (await text_in(this.handle)) !== this.known) return false;
    const stream = await this.handle.createWritable();
    await stream.write(text);
    await stream.close();
    this.known = text;
    return true;
  }
  async read(): Promise<string> {
    if (this.handle === null) throw new Error('no file has been chosen');
    return (this.known = await text_in(this.handle));
  }
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
