// A server for tests of the page: it speaks the protocol of `thimble view`, with a made-up tip in place of a controller.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { type IncomingMessage, type ServerResponse, createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { type WebSocket, WebSocketServer } from 'ws';

import type { Hello, MaterialKey, PageMessage, SceneStarted, ServerMessage } from '../src/protocol';
import { read_scene_image } from '../src/scene_image';
import { Touch } from './touch';

const kPage = dirname(dirname(fileURLToPath(import.meta.url)));
export const kTop = join(kPage, '../../..');
const kRate_Hz = 60;
// The page runs nothing but what it is built of; its icon is a data URL.
const kPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; form-action 'none'";
const kTypes: Record<string, string> = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };

export interface Options {
  scene?: string; // a name in scenes/, or the path of a scene file
  port?: number; // 0: any
  arms?: number;
  simulated?: boolean;
  token?: string;
}

// The command that compiles scenes: $THIMBLE, or that of the build beside the sources.
export function compile(scene: string): Uint8Array {
  const thimble = process.env.THIMBLE ?? join(kTop, 'build/release/bin/thimble');
  const file = existsSync(scene) ? scene : join(kTop, 'scenes', scene, `${scene}.scene.json`);
  if (!existsSync(thimble)) throw new Error(`there is no ${thimble}: build it, or name it in THIMBLE`);
  const folder = mkdtempSync(join(tmpdir(), 'thimble-mock-'));
  try {
    const image = join(folder, 'scene.thim');
    execFileSync(thimble, ['compile', file, '--output', image], { stdio: ['ignore', 'ignore', 'inherit'] });
    return new Uint8Array(readFileSync(image));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

export class Mock {
  readonly received: PageMessage[] = [];
  // When a state left, by its tick: for measuring how long it takes to the picture.
  readonly sent_ms = new Map<number, number>();
  readonly token: string;
  refuses = false; // materials
  touch!: Touch;
  private image!: Uint8Array;
  private name = '';
  private crc = 1;
  private link_up = true;
  private max_force = 8;
  private readonly clients = new Map<WebSocket, boolean>(); // may it control
  private readonly http = createServer((request, response) => this.answer(request, response));
  private readonly sockets = new WebSocketServer({ noServer: true });
  timer: NodeJS.Timeout | undefined;
  private beats: NodeJS.Timeout | undefined;

  constructor(private readonly options: Options = {}) {
    this.token = options.token ?? 'letmein';
    this.load(options.scene ?? 'blocks');
    this.http.on('upgrade', (request, socket, head) => {
      this.sockets.handleUpgrade(request, socket, head, (client) => this.welcome(client, request));
    });
  }

  get port(): number {
    const address = this.http.address();
    return typeof address === 'object' && address !== null ? address.port : 0;
  }
  get url(): string {
    return `http://127.0.0.1:${this.port}/?token=${this.token}`;
  }

  async start(port = this.options.port ?? 0): Promise<void> {
    await new Promise<void>((resolve, reject) => {
      this.http.once('error', reject);
      this.http.listen(port, '127.0.0.1', resolve);
    });
    this.beats = setInterval(() => this.broadcast({ type: 'link', up: this.link_up }), 2000);
    this.run();
  }

  // States, 60 a second.
  run(): void {
    let before = performance.now();
    this.timer = setInterval(() => {
      const now = performance.now();
      this.touch.step((now - before) / 1000);
      before = now;
      if (!this.link_up) return;
      const state = this.touch.state(this.options.simulated ?? true);
      this.sent_ms.set(state.tick ?? 0, Date.now());
      this.broadcast(state);
    }, 1000 / kRate_Hz);
  }

  async stop(): Promise<void> {
    clearInterval(this.timer);
    clearInterval(this.beats);
    for (const client of this.clients.keys()) client.terminate();
    this.clients.clear();
    this.http.closeAllConnections();
    await new Promise((resolve) => this.http.close(resolve));
  }

  // What happens when a controller vanishes and comes back.
  set_link(up: boolean): void {
    this.link_up = up;
    this.broadcast({ type: 'link', up });
    if (!up)
      this.broadcast({
        type: 'event',
        level: 'error',
        name: 'link-lost',
        cause: 'the controller does not answer',
        remedy: 'check the cable',
      });
  }

  broadcast(message: ServerMessage): void {
    this.broadcast_text(JSON.stringify(message));
  }

  broadcast_text(text: string): void {
    for (const client of this.clients.keys()) client.send(text);
  }

  load(scene: string): void {
    this.image = compile(scene);
    const model = read_scene_image(this.image);
    this.name = model.name;
    ++this.crc;
    const mode = (this.touch as Touch | undefined)?.mode;
    const time_s = (this.touch as Touch | undefined)?.time_s ?? 0;
    this.touch = new Touch(model, this.options.arms ?? 1);
    this.touch.time_s = time_s;
    if (mode === 'ready' || mode === 'armed') this.touch.command('home');
    if (mode === 'armed') this.touch.command('arm');
    this.broadcast(this.started());
  }

  // As a controller that has no scene.
  unload(): void {
    this.image = new Uint8Array();
    this.name = '';
    this.touch = new Touch({ name: '', tip_radius_m: 0, objects: [], triangles: 0 }, this.options.arms ?? 1);
    this.broadcast(this.started());
  }

  private started(): SceneStarted {
    return {
      type: 'scene',
      name: this.name,
      crc: this.crc,
      objects: this.touch.scene.objects.map(({ name }, i) => ({ name, material: this.touch.materials[i] })),
    };
  }

  private welcome(client: WebSocket, request: IncomingMessage): void {
    const may_control = new URL(request.url ?? '/', 'http://mock').searchParams.get('token') === this.token;
    this.clients.set(client, may_control);
    client.on('close', () => this.clients.delete(client));
    client.on('message', (data) => this.take(client, String(data)));
    client.send(JSON.stringify(this.hello(may_control)));
    client.send(JSON.stringify(this.started()));
  }

  private hello(may_control: boolean): Hello {
    return {
      type: 'hello',
      version: '0.1.0',
      simulated: this.options.simulated ?? true,
      may_control,
      arms: this.options.arms ?? 1,
      device: { address: 'mock', board: 'sim', firmware: '0.1.0', arm: 'premium-1.5' },
      parameters: [
        { name: 'max_force', value: this.max_force, unit: 'N', min: 0.5, max: 8.5, writable: true, text: 'the most that the hand feels' },
      ],
    };
  }

  private take(client: WebSocket, text: string): void {
    const message = JSON.parse(text) as PageMessage;
    this.received.push(message);
    const refuse = (cause: string, remedy: string) =>
      client.send(JSON.stringify({ type: 'event', level: 'error', name: 'refused', cause, remedy }));
    const stops = message.type === 'command' && message.verb === 'stop'; // anybody may
    if (!stops && !this.clients.get(client)) return refuse('this page may only look', 'open the address with the token');
    switch (message.type) {
      case 'hand':
        return this.touch.move_hand(message.arm, message.position_m);
      case 'command': {
        const why = this.touch.command(message.verb);
        return why === null ? undefined : refuse(`arming was refused: ${why}`, 'home the arm');
      }
      case 'pick':
        return this.load(message.scene);
      case 'material':
        if (this.refuses) {
          refuse('the scene does not compile with it', 'choose another value');
          return this.broadcast(this.started());
        }
        this.touch.materials[message.object][message.key as MaterialKey] = message.value;
        ++this.crc;
        return this.broadcast(this.started());
      case 'save':
        return this.broadcast({
          type: 'event',
          level: 'info',
          name: 'saved',
          cause: 'written to a file of the mock, which is none',
          remedy: '',
        });
      case 'parameter':
        this.max_force = message.value;
        for (const [other, may_control] of this.clients) other.send(JSON.stringify(this.hello(may_control)));
        return;
    }
  }

  private answer(request: IncomingMessage, response: ServerResponse): void {
    const path = new URL(request.url ?? '/', 'http://mock').pathname;
    if (path === '/scene.thim' && this.image.length === 0) return void response.writeHead(404).end();
    if (path === '/scene.thim') return void response.writeHead(200, { 'content-type': 'application/octet-stream' }).end(this.image);
    if (path === '/scenes.json') {
      const scenes = readdirSync(join(kTop, 'scenes'), { withFileTypes: true }).filter((it) => it.isDirectory());
      return void response.writeHead(200, { 'content-type': 'application/json' }).end(JSON.stringify(scenes.map((it) => it.name)));
    }
    const file = join(kPage, 'dist', normalize(path === '/' ? '/index.html' : path));
    if (!existsSync(file)) return void response.writeHead(404).end();
    response
      .writeHead(200, { 'content-type': kTypes[extname(file)] ?? 'application/octet-stream', 'content-security-policy': kPolicy })
      .end(readFileSync(file));
  }
}
