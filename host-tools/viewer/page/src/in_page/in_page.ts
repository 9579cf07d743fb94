// The transport of the static site: the device is in the page, in a worker, and another worker compiles its scenes.
import { not_kept } from '../not_kept';
import { type PageMessage, type SceneStarted, is_unknown, parse_message } from '../protocol';
import { LinkError, type LinkedScene, is_scene_link, linked_scene, scene_fragment } from '../scene_link';
import type { Listener, Replayer, Transport } from '../transport';
import type { CompileDone, FromCompiler, ReplayDone, ToCompiler } from './compiler_worker';
import type { DeviceOptions } from './device';
import type { FromDevice, ToDevice } from './device_worker';
import { Gallery, kLinkedFolder, kSuffix } from './gallery';
import { forget_text, keep_text, kept_text } from './kept_texts';
import { KeptFiles } from './own_files';
import { SerialBoard, choose_port, serial } from './serial';

const kSilent_ms = 1500;
const kMostSources = 8; // the newest; of what runs, and of what may run again

const kKeepOffline_ms = 5000; // what is for a later visit is fetched after what this one needs

// Fetched, compiled and begun before the rest of the page runs.
const module_compiled = WebAssembly.compileStreaming(fetch(new URL('thimble.wasm', document.baseURI)));
module_compiled.catch(() => {}); // begin() tells it

// What an image was compiled of, in the session's file of this name.
type Source = LinkedScene & { file: string };

export class InPage implements Transport {
  private readonly device = new Worker(new URL('./device_worker.ts', import.meta.url), { type: 'module', name: 'device' });
  private readonly compiler = new Worker(new URL('./compiler_worker.ts', import.meta.url), { type: 'module', name: 'compiler' });
  readonly own_files = new KeptFiles((path, bytes) => {
    this.to_compiler({ put: { path, bytes } });
    if (bytes === null) this.gallery.fetch_again(); // which may have got one of this name since it was added
  });
  readonly gallery = new Gallery((path, bytes) => this.own_files.has(path) || this.to_compiler({ put: { path, bytes } }));
  private running: Uint8Array<ArrayBuffer> | null = null;
  private last_state_ms = 0;
  private up = true; // the session has its device
  private failed = false;
  private compiled: WebAssembly.Module | null = null;
  private board: SerialBoard | null = null;
  private arms = 1;
  private devices = 0; // that have begun
  private readonly compiling: ((done: CompileDone) => void)[] = [];
  private readonly sources = new Map<number, Source>(); // by the CRC of the image
  private readonly replays: ((done: ReplayDone) => void)[] = [];
  private running_crc = 0;
  private last_recording: Uint8Array<ArrayBuffer> | null = null;
  private records = false;
  private early: Uint8Array[] = []; // for the board that is being opened
  private readonly unkept = new Set<string>(); // scenes that could not be kept
  private folder = '/scenes'; // of the scene that runs
  readonly keeps = 'Keep in this browser';
  readonly choose_board?: () => Promise<void>;

  constructor(private readonly listener: Listener) {
    if (serial() !== null) this.choose_board = () => this.leave_for_board();
    this.device.onmessage = ({ data }: MessageEvent<FromDevice>) => this.take(data);
    this.compiler.onmessage = ({ data }: MessageEvent<FromCompiler>) =>
      'replayed' in data ? this.replays.shift()?.(data) : this.compiling.shift()?.(data);
    document.addEventListener('visibilitychange', () => this.to_device({ pause: document.hidden && this.board === null }));
    addEventListener('hashchange', () => void this.follow_link());
    void this.begin();
    this.gallery.names().catch(() => {}); // fetched before it is needed; begin() tells what is wrong
    setInterval(() => this.watch(), 250);
  }

  send(message: PageMessage): boolean {
    if (this.failed) return false;
    if (message.type === 'pick') {
      // The address no longer tells what runs.
      if (is_scene_link(location.hash)) history.replaceState(history.state, '', location.pathname + location.search);
      return this.pick(message.scene);
    } else this.to_device({ post: message });
    return true;
  }
  async image(): Promise<Uint8Array<ArrayBuffer> | null> {
    return this.running;
  }
  scenes(): Promise<string[]> {
    return this.gallery.names();
  }

  async recording(): Promise<Uint8Array<ArrayBuffer>> {
    if (this.last_recording === null) throw new Error('nothing has been recorded');
    return this.last_recording;
  }
  readonly replay: Replayer = (name, bytes, wants_log) =>
    new Promise((done) => {
      this.replays.push(done);
      this.to_compiler({ replay: { name, bytes, wants_log } });
    });

  listen(port: MessagePort | null): void {
    this.to_device({ sound: port }, port === null ? [] : [port]);
  }
  async put_file(name: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    const path = `${this.folder}/${name}`;
    if (this.gallery.has_file(path)) throw new Error(`${name} is another file, of the gallery; rename the one that is added`);
    await this.own_files
      .keep(path, bytes)
      .catch((error: unknown) => this.listener.on_message(not_kept(name, error, 'it is there until the page is left; add it again then')));
  }
  restore(scene: string): void {
    forget_text(`${scene}${kSuffix}`);
  }

  // The address that opens the scene that runs. Throws LinkError.
  async link_to_scene(): Promise<string> {
    const source = this.sources.get(this.running_crc);
    if (source === undefined) throw new LinkError('the text of the scene that runs is not known here', 'load a scene, then link to it');
    const own = this.own_files_of(source);
    if (own.length > 0)
      throw new LinkError(
        `the scene names ${own.join(', ')}, and a link carries no files`,
        'send the scene with its files, or use those of the gallery',
      );
    return new URL(await scene_fragment(source), document.baseURI).href;
  }

  private own_files_of({ text, folder = kLinkedFolder }: LinkedScene): string[] {
    const named = this.own_files.all.map(({ path }) => path).filter((path) => path.startsWith(`/scenes/${folder}/`));
    const names = named.map((path) => path.slice(path.lastIndexOf('/') + 1));
    return names.filter((name) => text.includes(`"${name}"`) || text.includes(`/${name}"`));
  }

  private async begin(): Promise<void> {
    try {
      this.compiled = await module_compiled;
      this.to_compiler({ begin: this.compiled });
      await this.own_files.load();
      this.begin_device({});
      if (!(await this.follow_link())) this.pick(await this.gallery.first());
    } catch (error) {
      this.fail(error instanceof Error ? error.message : String(error));
    }
  }

  // False: not now.
  private pick(scene: string): boolean {
    if (this.board === null && this.gallery.arms(scene) !== this.arms) {
      if (this.records) {
        this.say('recording-runs', 'this scene needs another device, and the recording is of this one', 'end the recording first');
        return false;
      }
      this.take_arms(this.gallery.arms(scene));
    }
    this.unkept.delete(scene);
    this.to_device({ post: { type: 'pick', scene } });
    return true;
  }
  // False: the address has no scene, or a damaged one.
  private async follow_link(): Promise<boolean> {
    if (!is_scene_link(location.hash)) return false;
    try {
      return this.pick(await this.gallery.take(await linked_scene(location.hash), location.hash.slice(-4)));
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      const remedy = error instanceof LinkError ? error.remedy : 'load the page again';
      this.say('bad-link', cause, remedy);
      return false;
    }
  }

  // Another simulated device, with so many arms.
  private take_arms(arms: number): void {
    this.running = null;
    this.begin_device({ arms });
  }
  private begin_device(options: DeviceOptions): void {
    if (this.compiled === null) throw new Error('the page has not loaded yet');
    this.arms = options.arms ?? 1;
    ++this.devices;
    this.early = [];
    this.to_device({ begin: { compiled: this.compiled, options, number: this.devices } });
    this.to_device({ pause: document.hidden });
  }

  // A board goes on while the page is hidden, and so does its session.
  private async leave_for_board(): Promise<void> {
    if (this.records) throw new Error('the device in the page is being recorded');
    const port = await choose_port();
    const last = this.board;
    await last?.close();
    this.board = null;
    let begun = false;
    const board = await SerialBoard.begin(
      port,
      (open) => {
        if (begun) this.to_device({ port_open: open });
        else this.begin_device({ serial: true });
        begun = true;
      },
      (bytes) => this.to_device({ port_in: bytes }),
    ).catch((error: unknown) => {
      if (last !== null) this.to_device({ port_open: false }); // the session is still that of the last board
      throw error;
    });
    this.board = board;
    this.running = null;
    for (const bytes of this.early.splice(0)) board.write(bytes);
  }

  private take(data: FromDevice): void {
    if ('message' in data) {
      const message = parse_message(data.message);
      if (message === null) return;
      if (message.type === 'state') {
        this.last_state_ms = performance.now();
        if (this.up) this.listener.on_link('live');
      } else if (message.type === 'link') {
        this.up = message.up;
        this.listener.on_link(message.up ? 'connecting' : 'controller-lost');
      }
      if (message.type === 'recording') this.records = message.on;
      if (message.type === 'event' && message.name === 'scene-unknown') return; // said when it is not found
      if (message.type === 'scene') return this.take_scene(message);
      this.listener.on_message(message);
    } else if ('image' in data) this.running = data.image;
    else if ('recording' in data) this.last_recording = data.recording;
    else if ('compile' in data) void this.compile(data.compile, data.number);
    else if ('save' in data) this.keep_text(data.save);
    else if ('port_out' in data) this.port_out(data.port_out, data.number);
    else if ('load' in data) {
      document.documentElement.dataset.load = JSON.stringify(data.load);
      this.listener.on_load?.(data.load);
    } else if ('failed' in data) this.fail(data.failed);
  }

  // What the session takes for saved is not where the browser does not keep it.
  private keep_text({ file, text }: { file: string; text: string }): void {
    const scene = file.replace(kSuffix, '');
    try {
      keep_text(file, text);
      this.unkept.delete(scene);
    } catch (error) {
      this.unkept.add(scene);
      this.listener.on_message(not_kept('the scene', error, 'download it'));
    }
  }

  private take_scene(scene: SceneStarted): void {
    this.running_crc = scene.crc;
    const source = this.sources.get(scene.crc);
    if (source !== undefined) this.folder = `/scenes/${source.folder ?? kLinkedFolder}`;
    if (scene.pick !== undefined && this.unkept.has(scene.pick)) scene.unsaved = true;
    if (is_unknown(scene)) void this.look_for(scene);
    this.listener.on_message({ ...scene, sought: is_unknown(scene) });
  }

  private async compile(job: { file: string; text?: string }, number: number): Promise<void> {
    try {
      const { path, text } = await this.gallery.open(job.file);
      const source = { ...this.gallery.describe(job.file), file: job.file, text: job.text ?? kept_text(job.file) ?? text };
      const { head, crc, image } = await this.compiled_of(path, source.text);
      if (crc !== null) this.keep(crc, source);
      if (number === this.devices) this.to_device({ deliver: { head, image } }, [image.buffer]); // otherwise that device is gone
    } catch (error) {
      if (number !== this.devices) return;
      const cause = error instanceof Error ? error.message : String(error);
      const issue = { name: 'no-such-scene', cause, remedy: 'pick another scene, or load the page again' };
      const head = JSON.stringify({ name: '', objects: [], warnings: [], issues: [issue], more: 0, text: '' });
      this.to_device({ deliver: { head, image: new Uint8Array() } });
    }
  }
  private compiled_of(path: string, text: string): Promise<CompileDone> {
    return new Promise((done) => {
      this.compiling.push(done);
      this.to_compiler({ job: { file: path, text } });
    });
  }

  // A board runs a scene that this session has not uploaded.
  private async look_for(scene: SceneStarted): Promise<void> {
    const number = this.devices;
    const learnt = await this.find(scene).catch(() => null);
    if (number !== this.devices || this.running_crc !== scene.crc) return;
    if (learnt !== null) this.to_device({ learn: learnt }, [learnt.image.buffer]);
    else this.listener.on_message(scene);
  }
  // With the same image: one that was compiled here before, or one of the gallery. Null: there is none.
  private async find({ name, crc }: SceneStarted): Promise<{ head: string; image: Uint8Array<ArrayBuffer> } | null> {
    const known = this.sources.get(crc);
    for (const file of known ? [known.file] : await this.gallery.titled(name)) {
      const { path, text: original } = await this.gallery.open(file);
      const text = kept_text(file) ?? original;
      for (const compiled of new Set(known ? [known.text] : [text, original])) {
        const { head, crc: found, image } = await this.compiled_of(path, compiled);
        if (found !== crc) continue;
        this.keep(crc, known ?? { ...this.gallery.describe(file), file, text: compiled });
        const draft = compiled === text ? undefined : compiled;
        return { head: JSON.stringify({ ...JSON.parse(head), file, text, draft }), image };
      }
    }
    return null;
  }

  private keep(crc: number, source: Source): void {
    this.sources.delete(crc);
    this.sources.set(crc, source);
    for (const oldest of this.sources.keys())
      if (this.sources.size > kMostSources && oldest !== this.running_crc) this.sources.delete(oldest);
  }

  // What the session says before the port's promise is kept is for the port too.
  private port_out(bytes: Uint8Array, number: number): void {
    if (number !== this.devices) return; // of a device that is gone
    if (this.board !== null) this.board.write(bytes);
    else this.early.push(bytes);
  }

  private fail(cause: string): void {
    this.failed = true;
    this.listener.on_link('server-gone');
    this.say('device-failed', cause, 'load the page again');
  }
  private say(name: string, cause: string, remedy: string): void {
    this.listener.on_message({ type: 'event', level: 'error', name, cause, remedy });
  }

  private watch(): void {
    if (!this.failed && this.up && !document.hidden && this.last_state_ms > 0 && performance.now() - this.last_state_ms > kSilent_ms)
      this.listener.on_link('silent');
  }

  private to_device(message: ToDevice, transfer: Transferable[] = []): void {
    this.device.postMessage(message, transfer);
  }
  private to_compiler(message: ToCompiler): void {
    this.compiler.postMessage(message);
  }
}

export function open_transport(_query: string, listener: Listener): Transport {
  if ('serviceWorker' in navigator) setTimeout(keep_offline, kKeepOffline_ms);
  return new InPage(listener);
}

function keep_offline(): void {
  navigator.serviceWorker.register(new URL('offline.js', document.baseURI)).catch(() => {}); // http: no
}
