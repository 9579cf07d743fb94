// Files that are dropped on the page, or chosen: meshes and grids of heights become objects, a scene file becomes the text.
import { Box3, Vector3 } from 'three';

import { make } from '../dom';
import type { SceneObjects } from '../scene_objects';
import { button } from './controls';
import type { EditorHost } from './editor';
import type { Edit } from './json_edits';
import * as edits from './scene_edits';
import { can_open_files, open_files } from './scene_file';
import type { Outline } from './scene_outline';
import { is_mesh_file, is_scene_file, object_of_file } from './templates';

interface Edited {
  edit(how: (text: string) => Edit[]): void;
  outline(): Outline | null;
  text(): string;
  select_last(): void;
  opened(file: FileSystemFileHandle, text: string): void; // a scene file that can be written
  taken(): void; // whatever came of it
}

// The size in which a mesh comes, whatever its unit: what a hand can go around.
const kLeast_m = 0.02;
const kMost_m = 0.2;
const kTop_m = -0.02; // below the tip's home

// As every file system takes it.
const name_of = (file: File): string => file.name.replace(/[^A-Za-z0-9._-]/g, '_');

export class Importer {
  readonly button: HTMLElement;
  private readonly input = make('input', { type: 'file', multiple: true, hidden: true }, { testid: 'editor-file' });
  private unfit: string[] = []; // names of meshes whose size is not known yet

  constructor(
    private readonly host: EditorHost,
    private readonly edited: Edited,
  ) {
    this.input.setAttribute('aria-label', 'Files to add');
    this.input.addEventListener('change', () => void this.take([...(this.input.files ?? [])]));
    this.button = make('span');
    this.button.append(
      button('Add files…', 'editor-files', () => void this.ask(), 'Meshes, heights (PNG, CSV) or a scene; or drop them on the page'),
      this.input,
    );
  }

  // handles: of the files, where the browser has them.
  async take(files: readonly File[], handles: readonly FileSystemFileHandle[] = []): Promise<void> {
    const scene = files.find((file) => is_scene_file(file.name));
    try {
      for (const file of files) if (file !== scene) await this.put(file);
      if (scene !== undefined) {
        const text = await scene.text();
        this.host.keeper.begin_anew(); // what was edited stays kept
        this.edited.edit((now) => edits.whole(now, text));
        const handle = handles[files.indexOf(scene)];
        if (handle !== undefined) this.edited.opened(handle, text);
      } else for (const file of files) this.add(name_of(file));
    } catch (error) {
      this.say(error);
    }
    this.input.value = '';
    this.edited.taken();
  }

  // Meshes that are new in the scene get a size and a place that can be felt.
  fit(objects: SceneObjects | null): void {
    if (objects === null) return;
    for (const name of this.unfit.splice(0)) {
      const index = objects.model.objects.findIndex((object) => object.name === name);
      const group = objects.group.children[index];
      if (group === undefined) {
        this.unfit.push(name);
        continue;
      }
      const box = new Box3().setFromObject(group);
      this.edited.edit((text) => fitted(text, index, box));
    }
  }

  private async ask(): Promise<void> {
    if (!can_open_files()) {
      this.input.click();
      return;
    }
    try {
      const handles = await open_files();
      await this.take(await Promise.all(handles.map((handle) => handle.getFile())), handles);
    } catch (error) {
      this.say(error);
    }
  }

  private say(error: unknown): void {
    const cause = error instanceof Error ? error.message : String(error);
    const remedy = 'put the file beside the scene file, and name it there';
    this.host.say({ type: 'event', level: 'error', name: 'no-file', cause, remedy });
  }

  private async put(file: File): Promise<void> {
    if (this.host.transport.put_file === undefined) throw new Error('this page cannot take files');
    await this.host.transport.put_file(name_of(file), new Uint8Array(await file.arrayBuffer()));
  }

  private add(file: string): void {
    const object = object_of_file(file, this.edited.outline());
    if (object === null) return;
    const name = edits.free_name(this.edited.text(), String(object.name));
    if (is_mesh_file(file)) this.unfit.push(name);
    this.edited.edit((text) => edits.add(text, object));
    this.edited.select_last();
  }
}

// By a power of ten, since it is the unit that is wrong.
function fitted(text: string, index: number, box: Box3): Edit[] {
  const size = box.getSize(new Vector3());
  const most_m = Math.max(...size.toArray());
  let factor = 1;
  while (most_m * factor < kLeast_m) factor *= 10;
  while (most_m * factor > kMost_m) factor /= 10;
  const centre = box.getCenter(new Vector3()).multiplyScalar(-factor);
  const z_m = kTop_m - (size.z * factor) / 2;
  const moved = edits.move(text, index, [centre.x, centre.y, centre.z + z_m]);
  return [...edits.scale(text, index, [factor, factor, factor]), ...moved];
}
