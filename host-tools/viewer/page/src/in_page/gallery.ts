// The scenes of the site: scenes/list.json names them and their files.
export interface GalleryScene {
  name: string; // "ring"
  file: string; // of the scene, below scenes/: "ring/ring.scene.json"
  files: string[]; // that it names
  path?: string; // of its scripted hand
  arms: number;
  picture?: string;
}

const kFirst = 'buttons';

export class Gallery {
  private list: Promise<GalleryScene[]> | null = null;
  private known: GalleryScene[] = [];
  private readonly texts = new Map<string, Promise<string>>(); // by the scene's file

  // put: gives a file to the compiler.
  constructor(private readonly put: (path: string, bytes: Uint8Array) => void) {}

  async names(): Promise<string[]> {
    return (await this.all()).map((scene) => scene.name);
  }
  async first(): Promise<string> {
    const names = await this.names();
    return names.includes(kFirst) ? kFirst : names[0];
  }

  // For how many arms it is.
  arms(name: string): number {
    return this.known.find((scene) => scene.name === name)?.arms ?? 1;
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

  // The path and the text of the scene that the session calls NAME.scene.json; its files are with the compiler.
  async open(name: string): Promise<{ path: string; text: string }> {
    const scene = (await this.all()).find((one) => `${one.name}.scene.json` === name);
    if (scene === undefined) throw new Error(`there is no scene ${name}`);
    let text = this.texts.get(scene.file);
    if (text === undefined) {
      text = this.fetch_all(scene);
      this.texts.set(scene.file, text);
      text.catch(() => this.texts.delete(scene.file)); // the next time perhaps
    }
    return { path: `/scenes/${scene.file}`, text: await text };
  }

  private async fetch_all(scene: GalleryScene): Promise<string> {
    const files = await Promise.all(
      scene.files.map(async (file) => ({ file, bytes: new Uint8Array(await (await get(file)).arrayBuffer()) })),
    );
    for (const { file, bytes } of files) this.put(`/scenes/${file}`, bytes);
    return (await get(scene.file)).text();
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
