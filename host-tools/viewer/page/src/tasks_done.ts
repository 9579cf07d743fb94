// The tasks that the user of this browser has done.
const kKey = 'thimble-tasks-done';

export class DoneTasks {
  private readonly names = new Set<string>(read());

  has(name: string): boolean {
    return this.names.has(name);
  }
  add(name: string): void {
    this.names.add(name);
    try {
      localStorage.setItem(kKey, JSON.stringify([...this.names]));
    } catch {
      // This browser keeps nothing: for this visit only.
    }
  }
}

function read(): string[] {
  try {
    const names: unknown = JSON.parse(localStorage.getItem(kKey) ?? '[]');
    return Array.isArray(names) ? names.map(String) : [];
  } catch {
    return [];
  }
}
