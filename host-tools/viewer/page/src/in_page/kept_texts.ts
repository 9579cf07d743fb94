// Scenes that the user has changed and kept, in this browser.
const kPrefix = 'thimble-scene:';

// Null where none is kept, or where the browser refuses storage.
export function kept_text(file: string): string | null {
  try {
    return localStorage.getItem(kPrefix + file);
  } catch {
    return null;
  }
}

// Throws where the browser does not keep it.
export const keep_text = (file: string, text: string): void => localStorage.setItem(kPrefix + file, text);

export function forget_text(file: string): void {
  if (kept_text(file) !== null) localStorage.removeItem(kPrefix + file);
}
