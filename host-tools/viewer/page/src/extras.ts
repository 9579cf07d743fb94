// What goes beyond seeing: sound, vibration, and where there are scenes to choose from, the gallery with its tasks.
import type { Alerts } from './alerts';
import { element } from './dom';
import type { GalleryView } from './gallery_view';
import { type Hello, type PageMessage, type RecordingState, type SceneStarted, type State, known_as } from './protocol';
import type { Recordings } from './recordings';
import { SoundButton, why_silent } from './sound_button';
import { show_share_button } from './share_button';
import type { TaskPanel } from './task_panel';
import type { SceneGallery, Transport } from './transport';
import { Vibration, can_shake } from './vibration';

export class Extras {
  private readonly sound: SoundButton;
  private readonly vibration = new Vibration(navigator);
  private states = 0;
  private since_s: number | null = null;
  private forces_Hz = 0;

  private gallery: GalleryView | null = null;
  private task: TaskPanel | null = null;
  private recordings: Recordings | null = null;
  private hello: Hello | null = null;
  private scene: SceneStarted | null = null;

  constructor(
    private readonly transport: Transport,
    private readonly send: (message: PageMessage) => boolean,
    alerts: Alerts,
    canvas: HTMLCanvasElement,
  ) {
    this.sound = new SoundButton((port) => transport.listen?.(port), alerts);
    this.show_vibration();
    addEventListener('gamepadconnected', () => this.show_vibration());
    addEventListener('gamepaddisconnected', () => this.show_vibration());
    if (transport.link_to_scene) show_share_button(() => transport.link_to_scene!(), alerts);
    void this.open_recordings(alerts);
    if (transport.gallery) void this.open_gallery(transport.gallery, canvas);
  }

  on_hello(hello: Hello): void {
    const every_tick = this.transport.listen !== undefined && hello.simulated;
    this.sound.allow(() => why_silent(every_tick, this.forces_Hz));
    this.hello = hello;
    this.leave_hand();
    this.task?.allow(hello.simulated && hello.may_control);
    this.recordings?.allow(hello.may_control);
  }

  // other: than the one that ran.
  on_scene(scene: SceneStarted, other: boolean): void {
    this.scene = scene;
    if (this.recordings) this.recordings.scene = known_as(scene);
    if (other) this.show_scene();
  }

  on_recording(state: RecordingState): void {
    this.recordings?.take(state);
  }

  on_state(state: State): void {
    this.count(state.time_s);
    this.vibration.take(state, performance.now());
    this.task?.take(state);
  }

  // The ghost lets the hand go.
  leave_hand(): void {
    this.task?.end_ghost();
  }

  // Once a frame.
  step(now_s: number): void {
    this.task?.step(now_s);
  }

  private async open_recordings(alerts: Alerts): Promise<void> {
    const { Recordings } = await import('./recordings');
    this.recordings = new Recordings(this.transport, this.send, alerts);
    if (this.hello) this.recordings.allow(this.hello.may_control);
    if (this.scene) this.recordings.scene = known_as(this.scene);
  }

  private async open_gallery(gallery: SceneGallery, canvas: HTMLCanvasElement): Promise<void> {
    for (const id of ['gallery', 'task']) element(id).hidden = false;
    const [{ GalleryView }, { TaskPanel }, { DoneTasks }] = await Promise.all([
      import('./gallery_view'),
      import('./task_panel'),
      import('./tasks_done'),
    ]);
    const done = new DoneTasks();
    this.gallery = new GalleryView(done, (scene) => this.send({ type: 'pick', scene }));
    this.task = new TaskPanel(
      gallery,
      done,
      (arm, position_m) => this.send({ type: 'hand', arm, position_m }),
      () => this.gallery?.mark(),
    );
    for (const type of ['pointerdown', 'keydown', 'wheel'])
      document.addEventListener(type, (event) => event.target === canvas && moves_hand(event) && this.task?.end_ghost(), kFirst);
    if (this.hello) this.on_hello(this.hello);
    this.show_scene();
    await this.gallery.fill(gallery);
    this.show_scene();
  }

  private show_scene(): void {
    const { scene } = this;
    if (scene === null) return;
    const name = known_as(scene);
    this.gallery?.mark(name);
    void this.task?.begin(
      name,
      scene.objects.map((object) => object.name),
    );
  }

  private count(time_s: number): void {
    this.since_s ??= time_s;
    ++this.states;
    const span_s = time_s - this.since_s;
    if (span_s >= 0 && span_s < 1) return;
    this.forces_Hz = span_s > 0 ? (this.states - 1) / span_s : 0;
    this.since_s = time_s;
    this.states = 1;
  }

  private show_vibration(): void {
    const button = element<HTMLButtonElement>('vibration');
    button.hidden = !can_shake(navigator);
    button.onclick = () => {
      this.vibration.on = !this.vibration.on;
      button.setAttribute('aria-pressed', String(this.vibration.on));
    };
  }
}

const kFirst = { capture: true, passive: true }; // before the hand's own listeners
// As in hand_control.ts.
function moves_hand(event: Event): boolean {
  if (event instanceof PointerEvent) return event.button === 0 && !event.shiftKey;
  if (event instanceof WheelEvent) return !event.ctrlKey;
  return event instanceof KeyboardEvent && /^(Arrow|Page)/.test(event.key);
}
