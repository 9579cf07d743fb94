// A scene as the fragment of an address: "#scene=", then base64url of the compressed JSON of LinkedScene. Its checksum (zlib's) finds a damaged link.
export interface LinkedScene {
  name: string; // under which it is picked
  folder?: string; // of the gallery: the scene may name files there
  arms?: number; // that it is for; without it one
  text: string; // of its file
}

// The message is the cause.
export class LinkError extends Error {
  constructor(
    cause: string,
    readonly remedy: string,
  ) {
    super(cause);
  }
}

const kPrefix = '#scene=';
const kMostCharacters = 32_768; // programs through which links go cut longer ones
const kMostBytes = 1 << 20; // of the JSON
const kFormat = 'deflate';

const damaged = (): LinkError => new LinkError('the link to a scene is damaged', 'copy the whole link again from where it was made');

export const is_scene_link = (fragment: string): boolean => fragment.startsWith(kPrefix);

// Throws LinkError: the scene is too large.
export async function scene_fragment({ name, folder, arms, text }: LinkedScene): Promise<string> {
  const json = new TextEncoder().encode(JSON.stringify({ name, folder, arms: arms === 1 ? undefined : arms, text }));
  const packed = json.length > kMostBytes ? null : await through(new CompressionStream(kFormat), json);
  const fragment = packed && kPrefix + to_base64url(packed);
  if (fragment !== null && fragment.length <= kMostCharacters) return fragment;
  throw new LinkError('the scene is too large for a link', 'put large data into files, or send the file of the scene');
}

// Throws LinkError: it is damaged, or too long.
export async function linked_scene(fragment: string): Promise<LinkedScene> {
  if (fragment.length > kMostCharacters) throw new LinkError('the link to a scene is too long', 'ask for the file of the scene');
  const json = await unpacked(fragment.slice(kPrefix.length)).catch(() => null);
  const { name, folder, arms = 1, text } = (json ?? {}) as Partial<LinkedScene>;
  const is_name = (it: unknown): it is string => typeof it === 'string' && /^[^/\\\p{Cc}]{1,80}$/u.test(it) && !/^\.+$/.test(it);
  if (!is_name(name) || typeof text !== 'string' || (arms !== 1 && arms !== 2) || (folder !== undefined && !is_name(folder)))
    throw damaged();
  return { name, folder, arms, text };
}

async function unpacked(text: string): Promise<unknown> {
  if (!/^[\w-]+$/.test(text)) throw damaged();
  const packed = Uint8Array.from(atob(text.replaceAll('-', '+').replaceAll('_', '/')), (letter) => letter.charCodeAt(0));
  const json = await through(new DecompressionStream(kFormat), packed);
  return JSON.parse(new TextDecoder('utf-8', { fatal: true, ignoreBOM: true }).decode(json));
}

const to_base64url = (bytes: Uint8Array): string =>
  btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''))
    .replaceAll('+', '-')
    .replaceAll('/', '_')
    .replaceAll('=', '');

// At most kMostBytes: a small link must not fill the memory.
async function through(stream: CompressionStream | DecompressionStream, bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const reader = new Blob([bytes]).stream().pipeThrough<Uint8Array<ArrayBuffer>>(stream).getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    parts.push(part.value);
    size += part.value.length;
    if (size <= kMostBytes) continue;
    await reader.cancel();
    throw damaged();
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}
