import type { ServerEvent } from './protocol';

// Why the browser does not keep something, as a banner.
export function not_kept(what: string, error: unknown, remedy: string): ServerEvent {
  const full = error instanceof DOMException && error.name === 'QuotaExceededError';
  const why = full ? 'its storage is full' : error instanceof Error ? error.message : String(error);
  return { type: 'event', level: 'error', name: 'not-kept', cause: `this browser does not keep ${what}: ${why}`, remedy };
}
