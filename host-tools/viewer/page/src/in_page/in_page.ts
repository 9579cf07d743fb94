// The transport of the static site: the device is in the page, in a worker, and another worker compiles its scenes.
import { type PageMessage, parse_message } from '../protocol';
import type { Listener, Transport } from '../transport';
import type { FromCompiler, ToCompiler } from './compiler_worker';
import type { DeviceOptions } from './device';
import type { FromDevice, ToDevice } from './device_worker';
import { Gallery } from './gallery';

const kSilent_ms = 1500;

export class InPage implements Transport {
  private readonly device = new Worker(new URL('./device_worker.ts', import.meta.url), { type: 'module', name: 'device' });
  private readonly compiler = new Worker(new URL('./compiler_worker.ts', import.meta.url), { type: 'module', name: 'compiler' });
  private readonly gallery = new Gallery((path, bytes) => this.to_compiler({ put: { path, bytes } }));
  private running: Uint8Array<ArrayBuffer> | null = null;
  private last_state_ms = 0;
  private failed = false;

  constructor(
    private readonly listener: Listener,
    private readonly options: DeviceOptions = {},
  ) {
    this.device.onmessage = ({ data }: MessageEvent<FromDevice>) => this.take(data);
    this.compiler.onmessage = ({ data }: MessageEvent<FromCompiler>) =>
      this.to_device({ deliver: { head: data.head, image: data.image } }, [data.image.buffer]);
    document.addEventListener('visibilitychange', () => this.to_device({ pause: document.hidden }));
    void this.begin();
    setInterval(() => this.watch(), 250);
  }

  send(message: PageMessage): boolean {
    if (this.failed) return false;
    this.to_device({ post: message });
    return true;
  }
  async image(): Promise<Uint8Array<ArrayBuffer> | null> {
    return this.running;
  }
  scenes(): Promise<string[]> {
    return this.gallery.names();
  }

  private async begin(): Promise<void> {
    try {
      const [device, compiler] = await Promise.all([load('device.wasm'), load('compiler.wasm')]);
      this.to_compiler({ begin: compiler });
      this.to_device({ begin: { compiled: device, options: this.options } });
      this.to_device({ pause: document.hidden });
      this.send({ type: 'pick', scene: await this.gallery.first() });
    } catch (error) {
      this.fail(error instanceof Error ? error.message : String(error));
    }
  }

  private take(data: FromDevice): void {
    if ('message' in data) {
      const message = parse_message(data.message);
      if (message === null) return;
      if (message.type === 'state') {
        this.last_state_ms = performance.now();
        this.listener.on_link('live');
      }
      this.listener.on_message(message);
    } else if ('image' in data) this.running = data.image;
    else if ('compile' in data) void this.compile(data.compile);
    else if ('load' in data) document.documentElement.dataset.load = JSON.stringify(data.load);
    else if ('failed' in data) this.fail(data.failed);
  }

  private async compile(job: { file: string; text?: string }): Promise<void> {
    try {
      const { path, text } = await this.gallery.open(job.file);
      this.to_compiler({ job: { file: path, text: job.text ?? text } });
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      const issue = { name: 'no-such-scene', cause, remedy: 'pick another scene, or load the page again' };
      const head = JSON.stringify({ name: '', objects: [], warnings: [], issues: [issue], more: 0, text: '' });
      this.to_device({ deliver: { head, image: new Uint8Array() } });
    }
  }

  private fail(cause: string): void {
    this.failed = true;
    this.listener.on_link('server-gone');
    this.listener.on_message({ type: 'event', level: 'error', name: 'device-failed', cause, remedy: 'load the page again' });
  }

  private watch(): void {
    if (!this.failed && !document.hidden && this.last_state_ms > 0 && performance.now() - this.last_state_ms > kSilent_ms)
      this.listener.on_link('silent');
  }

  private to_device(message: ToDevice, transfer: Transferable[] = []): void {
    this.device.postMessage(message, transfer);
  }
  private to_compiler(message: ToCompiler): void {
    this.compiler.postMessage(message);
  }
}

async function load(name: string): Promise<WebAssembly.Module> {
  return WebAssembly.compileStreaming(fetch(new URL(name, document.baseURI)));
}

export function open_transport(_query: string, listener: Listener): Transport {
  if ('serviceWorker' in navigator) void navigator.serviceWorker.register(new URL('offline.js', document.baseURI)).catch(() => {}); // http: no
  return new InPage(listener);
}
