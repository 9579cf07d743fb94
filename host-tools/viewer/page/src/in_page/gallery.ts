// The scenes of the site: scenes/list.json names them and their files. And those that came by a link.
import type { LinkedScene } from '../scene_link';
import { kept_text } from './kept_texts';

export interface GalleryScene {
  name: string; // "ring"
  title: string; // inside the scene: what a device calls it
  file: string; // of the scene, below scenes/: "ring/ring.scene.json"
  files: string[]; // that it names
  path?: string; // of its scripted hand
  arms: number;
  picture?: string;
}

const kFirst = 'buttons';
export const kSuffix = '.scene.json';
export const kLinkedFolder = 'linked'; // of scenes that come by a link and are of no folder of the gallery

export class Gallery {
  private list: Promise<GalleryScene[]> | null = null;
  private known: GalleryScene[] = [];
  private readonly linked = new Map<string, LinkedScene>(); // by the name under which they are picked
  private readonly texts = new Map<string, Promise<string>>(); // by the scene's file

  // put: gives a file to the compiler.
  constructor(private readonly put: (path: string, bytes: Uint8Array) => unknown) {}

  async names(): Promise<string[]> {
    return [...(await this.all()).map((scene) => scene.name), ...this.linked.keys()];
  }
  async first(): Promise<string> {
    const names = await this.names();
    return names.includes(kFirst) ? kFirst : names[0];
  }

  // The files of the scenes that a device calls so.
  async titled(title: string): Promise<string[]> {
    return (await this.all()).filter((scene) => scene.title === title).map((scene) => `${scene.name}${kSuffix}`);
  }

  // For how many arms it is.
  arms(name: string): number {
    return this.linked.get(name)?.arms ?? this.known.find((scene) => scene.name === name)?.arms ?? 1;
  }
  // With the addresses of their pictures.
  async pictures(): Promise<{ name: string; picture?: string }[]> {
    return (await this.all()).map(({ name, picture }) => ({ name, picture: picture && address(picture).href }));
  }
  // Of the scripted hand: CSV. Null: there is none.
  async hand_path(name: string): Promise<string | null> {
    const path = (await this.all()).find((scene) => scene.name === name)?.path;
    return path === undefined ? null : (await get(path)).text();
  }

  // Under which name it is picked now: its own, if it is the scene of that name here. mark: tells links of one name apart, so that what is kept
  // of one is not taken for the other.
  async take(scene: LinkedScene, mark: string): Promise<string> {
    const file = `${scene.name}${kSuffix}`;
    const same = (await this.all()).some((one) => one.name === scene.name);
    if (same && (kept_text(file) ?? (await this.open(file)).text) === scene.text) return scene.name;
    const name = `${scene.name} (link ${mark})`;
    this.linked.set(name, scene);
    return name;
  }
  // For a link, without its text.
  describe(file: string): Omit<LinkedScene, 'text'> {
    const name = file.replace(kSuffix, '');
    const { folder, arms, name: first = name } = this.linked.get(name) ?? { folder: this.folder(name), arms: this.arms(name) };
    return { name: first, folder, arms };
  }

  // The path and the text of the scene that the session calls NAME.scene.json; its files are with the compiler.
  async open(name: string): Promise<{ path: string; text: string }> {
    const scene = (await this.all()).find((one) => `${one.name}${kSuffix}` === name);
    const linked = this.linked.get(name.replace(kSuffix, ''));
    if (linked !== undefined) {
      const named = this.known.flatMap((one) => one.files).filter((file) => linked.text.includes(file.slice(file.lastIndexOf('/') + 1)));
      await this.fetch_files([...new Set(named)]);
      return { path: `/scenes/${linked.folder ?? kLinkedFolder}/${name}`, text: linked.text };
    }
    if (scene === undefined) throw new Error(`there is no scene ${name}`);
    let text = this.texts.get(scene.file);
    if (text === undefined) {
      text = this.fetch_all(scene);
      this.texts.set(scene.file, text);
      text.catch(() => this.texts.delete(scene.file)); // the next time perhaps
    }
    return { path: `/scenes/${scene.file}`, text: await text };
  }

  // Its files, when a scene is opened the next time.
  fetch_again(): void {
    this.texts.clear();
  }

  // path: "/scenes/ring/ring.obj".
  has_file(path: string): boolean {
    return this.known.some((scene) => scene.files.some((file) => path === `/scenes/${file}`));
  }

  private async fetch_all(scene: GalleryScene): Promise<string> {
    await this.fetch_files(scene.files);
    return (await get(scene.file)).text();
  }
  private async fetch_files(names: string[]): Promise<void> {
    const files = await Promise.all(names.map(async (file) => ({ file, bytes: new Uint8Array(await (await get(file)).arrayBuffer()) })));
    for (const { file, bytes } of files) this.put(`/scenes/${file}`, bytes);
  }
  private folder(name: string): string | undefined {
    return this.known.find((scene) => scene.name === name)?.file.split('/')[0];
  }
  private async all(): Promise<GalleryScene[]> {
    this.list ??= get('list.json').then((answer) => answer.json() as Promise<GalleryScene[]>);
    return (this.known = await this.list);
  }
}

const address = (file: string): URL => new URL(`scenes/${file}`, document.baseURI);

async function get(file: string): Promise<Response> {
  const answer = await fetch(address(file));
  if (!answer.ok) throw new Error(`scenes/${file}: the server answered ${answer.status}`);
  return answer;
}
