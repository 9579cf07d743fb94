// Files that the user has added to scenes, kept in this browser (IndexedDB). The compiler has them beside those of the gallery.
import { createStore, del, entries, set } from 'idb-keyval';

import type { OwnFile, OwnFiles } from '../transport';

type Bytes = Uint8Array<ArrayBuffer>;

const kStore = createStore('thimble-files', 'files');

export class KeptFiles implements OwnFiles {
  private readonly sizes = new Map<string, number>(); // by the path

  constructor(
    private readonly put: (path: string, bytes: Bytes | null) => void, // for the compiler; null: it is none any more
  ) {}

  // Those of earlier visits; none where the browser refuses storage.
  async load(): Promise<void> {
    try {
      for (const [path, bytes] of await entries<string, Bytes>(kStore)) this.take(path, bytes);
    } catch {
      // The page works without.
    }
  }

  has(path: string): boolean {
    return this.sizes.has(path);
  }
  get all(): OwnFile[] {
    return [...this.sizes].map(([path, size]) => ({ path, size })).sort((a, b) => (a.path < b.path ? -1 : 1));
  }

  // Rejects where the browser does not keep it; it is there all the same, for this visit.
  async keep(path: string, bytes: Bytes): Promise<void> {
    this.take(path, bytes);
    await set(path, bytes, kStore);
  }
  async remove(path: string): Promise<void> {
    this.sizes.delete(path);
    this.put(path, null);
    try {
      await del(path, kStore);
    } catch {
      // A browser that refuses storage has nothing to remove.
    }
  }

  private take(path: string, bytes: Bytes): void {
    this.sizes.set(path, bytes.length);
    this.put(path, bytes);
  }
}
