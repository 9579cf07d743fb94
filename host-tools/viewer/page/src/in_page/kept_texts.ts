// Scenes that the user has changed and kept, in this browser.
const kPrefix = 'thimble-scene:';

export const kept_text = (file: string): string | null => localStorage.getItem(kPrefix + file);
export const keep_text = (file: string, text: string): void => localStorage.setItem(kPrefix + file, text);

// False: none was kept.
export function forget_text(file: string): boolean {
  const had = kept_text(file) !== null;
  localStorage.removeItem(kPrefix + file);
  return had;
}
