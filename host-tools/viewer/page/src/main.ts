// The page of `thimble view` and of `thimble commission --page`: handles messages, draws frames, sends what the user does.
import './style.css';
import './alerts.css';
import './commission.css';
import './gallery.css';

import { open_transport } from '#transport';

import { Alerts } from './alerts';
import { CommissionView } from './commission_view';
import { element, make, set_text } from './dom';
import { Curves } from './curves';
import { EditorButton } from './editor_button';
import { reach_of } from './drag_mapping';
import { FrameStats } from './frame_stats';
import { HandControl } from './hand_control';
import { MaterialPanel } from './material_panel';
import { Extras } from './extras';
import { ParameterPanel } from './parameter_panel';
import { type Hello, type PageMessage, type SceneStarted, type ServerMessage, type State, type Verb, known_as } from './protocol';
import { type SceneModel, read_scene_image } from './scene_image';
import { kHomes, set_plane_color } from './scene_objects';
import { ScenePicture } from './scene_picture';
import { Stage, type Turn } from './stage';
import { StatusView } from './status_view';
import { Timeline } from './timeline';
import { take_query } from './token';
import type { Link } from './transport';

const kTextEvery_ms = 60;
const kCurvesEvery_ms = 80;
const kNotices: Partial<Record<Link, string>> = {
  silent: 'The server is there, but sends no telemetry. What you see is old.',
  'controller-lost': 'The link to the controller is lost. What you see is old; it goes on when the controller is back.',
  'server-gone': 'The server is gone. What you see is old; the page goes on trying to reach it.',
};
const kLinkTexts: Record<Link, string> = {
  connecting: 'connecting',
  live: 'live',
  silent: 'silent',
  'controller-lost': 'controller lost',
  'server-gone': 'server gone',
};

const query = take_query(); // has the token
const timeline = new Timeline();
const status = new StatusView();
const canvas = element<HTMLCanvasElement>('view');
const alerts = new Alerts(() => canvas.focus({ preventScroll: true }));

let hello: Hello | null = null;
let started: SceneStarted | null = null;
let commission: CommissionView | null = null; // the server is that of a commissioning
let link: Link = 'connecting';
let new_text = true; // not yet in the readings
let new_curves = true;

const stage = make_stage();
const picture = new ScenePicture(stage, canvas);
const hand = stage && new HandControl(stage, (arm, position_m) => send({ type: 'hand', arm, position_m }));
const curves = new Curves(timeline, show_pause);
lay_out_arms(1); // nothing moves when the server says so
const materials = new MaterialPanel(element('material'), send);
const parameters = new ParameterPanel(element('parameters'), send);
const transport = open_transport(query, { on_message, on_link, on_load: (load) => (status.load = load) });
const extras = new Extras(transport, send, alerts, canvas);
const editing = new EditorButton({ place: element('editor'), stage, transport, send, say: (event) => alerts.say(event) }, show_permission);
if (hand) hand.yields = () => editing.editor?.wants_press ?? false;

// again: called in place of this, if the user has to be asked first and agrees.
function send(message: PageMessage, again: () => void = () => send(message)): boolean {
  if (message.type === 'pick' && !editing.may_leave(again)) return false;
  if (message.type === 'command' || message.type === 'pick') {
    alerts.asked();
    extras.leave_hand();
  }
  const sent = transport.send(message);
  if (sent && message.type === 'pick') editing.on_pick(message.scene);
  return sent;
}

function make_stage(): Stage | null {
  try {
    return new Stage(canvas);
  } catch (error) {
    alerts.say({
      level: 'error',
      name: 'no-picture',
      cause: 'this browser has no WebGL 2',
      remedy: 'switch hardware acceleration on; the rest works',
    });
    console.error(error);
    return null;
  }
}

// --- Messages of the server

function on_message(message: ServerMessage): void {
  editing.on_message(message);
  switch (message.type) {
    case 'hello':
      return on_hello(message);
    case 'scene':
      return on_scene(message);
    case 'state':
      return on_state(message);
    case 'event':
      return alerts.say(message);
    case 'recording':
      return extras.on_recording(message);
  }
}

function on_hello(it: Hello): void {
  if (it.commission) {
    commission ??= new CommissionView(stage, canvas, send);
    commission.begin(it);
    return;
  }
  if (hello?.device?.address !== it.device?.address) alerts.forget_device();
  hello = it;
  if (hand?.arms.some((arm) => arm >= it.arms)) choose_hand('0'); // the last scene had more
  const device = it.device ?? {};
  const device_text = [device.arm, device.board, device.firmware, device.address].filter(Boolean).join(' · ');
  set_text(element('device'), device_text);
  element('device').title = device_text;
  element('readonly').hidden = it.may_control || readonly_hidden;
  for (const id of ['hand-help', 'hand-hint']) element(id).hidden = !can_move_hand();
  for (const id of ['two-help', 'arms']) element(id).hidden = !can_move_hand() || it.arms < 2;
  element('legend-arm-1').hidden = it.arms < 2;
  if (picture.arms !== it.arms) {
    lay_out_arms(it.arms);
    curves.update(); // with their axes at once
  }
  parameters.show(it.parameters ?? []);
  show_permission();
  extras.on_hello(it);
  void load_scene_names();
}

function lay_out_arms(arms: number): void {
  status.lay_out(arms);
  curves.lay_out(arms);
  picture.lay_out(arms);
}

const can_move_hand = (): boolean => hello !== null && hello.may_control && hello.simulated;

// Disables buttons that would have no effect, with the reason.
function show_permission(): void {
  const may = hello !== null && hello.may_control && (link === 'live' || link === 'connecting' || link === 'silent');
  for (const button of document.querySelectorAll<HTMLButtonElement>('[data-verb], #picker button')) button.disabled = !may;
  // Homing takes the present position of the arm as home. With --scene the server disarms and moves the hand there.
  const armed = timeline.live.newest?.mode === 'armed';
  element<HTMLButtonElement>('home').disabled = !may || (armed && !hello?.simulated);
  element<HTMLSelectElement>('scenes').disabled = !may;
  editing.enable(may);
  materials.enable(may && started !== null && started.objects.length > 0);
  parameters.enable(may);
  hand?.enable(may && can_move_hand() && !timeline.paused);
}

function on_scene(it: SceneStarted): void {
  const other = started?.name !== it.name || started.objects.length !== it.objects.length;
  started = it;
  const edited = editing.on_scene(it);
  if (other) {
    timeline.forget();
    curves.forget_zoom();
    show_pause(); // it has ended
  }
  set_text(element('scene'), it.name || 'none');
  alerts.follow_scene(it);
  extras.on_scene(it, other);
  choose_scene_name(it);
  materials.show(it);
  show_permission();
  clearTimeout(reload);
  // A slider makes many images that differ in one number; only the last one is loaded.
  reload = setTimeout(() => void load_scene(other && !edited), other || edited ? 0 : 300);
}
let reload: ReturnType<typeof setTimeout> | undefined;

async function load_scene(look: boolean): Promise<void> {
  const expected = started;
  try {
    const bytes = await transport.image();
    if (expected !== started || editing.editor?.is_dragging) return; // another one runs now, or will
    if (bytes === null) return hide_scene();
    show_scene(read_scene_image(bytes), look);
  } catch (error) {
    if (expected !== started) return;
    hide_scene();
    const cause = error instanceof Error ? error.message : String(error);
    alerts.say({ level: 'error', name: 'no-scene-image', cause, remedy: 'load a scene; tips and forces are shown all the same' });
  }
}

function hide_scene(): void {
  picture.hide();
  editing.show(null);
  if (hand) hand.reaches = [];
}

function show_scene(model: SceneModel, look: boolean): void {
  const arms = hello?.arms ?? 1;
  picture.show(model, arms, look);
  const { objects } = picture;
  if (objects === null) return;
  if (hand) hand.reaches = (kHomes[arms] ?? []).map((home) => reach_of(objects.surfaces, home));
  editing.show(objects);
}

function on_state(state: State): void {
  if (commission) {
    timeline.live.push(state);
    commission.update(state);
    picture.on_state();
    return;
  }
  const mode_was = timeline.live.newest?.mode;
  timeline.live.push(state);
  if (state.mode !== mode_was) {
    show_permission();
    const next = state.mode === 'faulted' ? 'clear' : state.mode === 'armed' ? '' : 'arm';
    for (const button of document.querySelectorAll<HTMLElement>('[data-verb]'))
      button.classList.toggle('main', button.dataset.verb === next);
  }
  if (link === 'live') status.announce(state);
  extras.on_state(state);
  alerts.follow(state);
  state.arms.forEach((arm, i) => arm !== null && hand?.follow(i, arm.hand_m ?? arm.tip_m));
  if (timeline.paused) return;
  all_new();
}

function all_new(): void {
  picture.on_state();
  new_text = new_curves = true;
}

function on_link(now: Link): void {
  link = now;
  // A commissioning that is over has no server any more.
  const text = commission?.is_over ? undefined : kNotices[now];
  const notice = element('notice');
  if (text !== undefined) set_text(notice, text);
  if (text !== undefined || now === 'live' || commission?.is_over) notice.hidden = text === undefined;
  set_text(element('link'), kLinkTexts[now]);
  element('link').className = now === 'live' ? 'good' : now === 'connecting' ? '' : 'bad';
  if (now !== 'live' && now !== 'connecting' && !commission?.is_over) status.announce_unknown(kLinkTexts[now]);
  show_permission();
}

async function load_scene_names(): Promise<void> {
  try {
    const names = await transport.scenes();
    const list = element<HTMLSelectElement>('scenes');
    const same = [...list.options].map((option) => option.value).join('\n');
    if (names.length === 0 || names.join('\n') === same) return;
    list.replaceChildren(...names.map((name) => make('option', { textContent: name, value: name })));
    if (started) choose_scene_name(started);
  } catch {
    // The state of the link names the reason.
  }
}

// The picker shows the running scene, unless the user is choosing. For a scene that is not in the list it is empty.
function choose_scene_name(scene: SceneStarted): void {
  const list = element<HTMLSelectElement>('scenes');
  const name = known_as(scene);
  if (document.activeElement !== list) list.selectedIndex = [...list.options].findIndex((option) => option.value === name);
}

// --- Actions of the user

const { choose_board } = transport;
if (choose_board) {
  element('board').hidden = false;
  element('board').addEventListener('click', () =>
    choose_board().catch((error: unknown) => {
      const cause = error instanceof Error ? error.message : String(error);
      alerts.say({ level: 'error', name: 'no-board', cause, remedy: 'plug the board in, and choose its port' });
    }),
  );
}
element<HTMLFormElement>('picker').addEventListener('submit', (event) => {
  event.preventDefault();
  const scene = element<HTMLSelectElement>('scenes').value;
  if (scene !== '') send({ type: 'pick', scene });
});
for (const button of document.querySelectorAll<HTMLButtonElement>('[data-verb]'))
  button.addEventListener('click', () => send({ type: 'command', verb: button.dataset.verb as Verb }));
// Anybody's, also of a page that may only look: every device on the bus brakes and switches its motors off.
function stop(): void {
  if (send({ type: 'command', verb: 'stop' })) return;
  alerts.say({ level: 'error', name: 'not-stopped', cause: 'the page has lost its server', remedy: 'press the e-stop button of the arm' });
}
element('stop').addEventListener('click', stop);
let readonly_hidden = false;
element('hide-readonly').addEventListener('click', () => {
  readonly_hidden = element('readonly').hidden = true;
  canvas.focus({ preventScroll: true });
});
document.addEventListener('keydown', (event) => event.key === 'Escape' && stop(), { capture: true });
for (const button of document.querySelectorAll<HTMLButtonElement>('[data-turn]'))
  button.addEventListener('click', () => stage?.turn(button.dataset.turn as Turn));
element('reset-view').addEventListener('click', () => stage?.reset());

// One arm, or all of them.
function choose_hand(choice: string): void {
  const arms = choice === 'both' ? [0, 1] : [Number(choice)];
  if (hello === null || arms.some((arm) => arm >= hello!.arms)) return;
  hand?.choose(arms);
  for (const radio of document.querySelectorAll<HTMLInputElement>('input[name=arm]')) radio.checked = radio.value === choice;
}
for (const radio of document.querySelectorAll<HTMLInputElement>('input[name=arm]'))
  radio.addEventListener('change', () => choose_hand(radio.value));
const kHandKeys: Record<string, string> = { 1: '0', 2: '1', 3: 'both' };
canvas.addEventListener('keydown', (event) => {
  if (event.key in kHandKeys) choose_hand(kHandKeys[event.key]);
});

const scrubber = element<HTMLInputElement>('scrubber');
scrubber.addEventListener('input', () => {
  timeline.seek(scrubber.valueAsNumber);
  curves.forget_zoom();
  show_pause();
});
element('pause').addEventListener('click', () => {
  if (timeline.paused) timeline.resume();
  else timeline.pause();
  curves.forget_zoom();
  show_pause();
});
function show_pause(): void {
  set_text(element('pause'), timeline.paused ? 'Go live' : 'Pause');
  show_permission();
  all_new();
}
// The header is sticky; what is below it has to know how high it is.
new ResizeObserver(([{ target }]) => document.body.style.setProperty('--header', `${(target as HTMLElement).offsetHeight}px`)).observe(
  document.querySelector('header')!,
);
const follow_theme = () => set_plane_color(getComputedStyle(canvas).getPropertyValue('--plane').trim());
follow_theme();
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  follow_theme();
  curves.redraw();
  stage?.touch();
});

// --- Frames

const frames = new FrameStats(canvas.dataset);
let text_ms = 0;
let curves_ms = 0;
let before_ms = performance.now();

function frame(now_ms: number): void {
  requestAnimationFrame(frame);
  const begin_ms = performance.now();
  hand?.step(now_ms / 1000, Math.min((now_ms - before_ms) / 1000, 0.1));
  materials.flush();
  extras.step(now_ms / 1000);
  before_ms = now_ms;
  if (hand) picture.show_moves(hand.busy ? hand.axes : null, hand.arms);
  const state = timeline.state;
  const drew = picture.draw(now_ms, state);
  if (now_ms - text_ms > kTextEvery_ms) {
    show_status();
    if (new_text && state !== undefined) show_readings(state);
    text_ms = now_ms;
  }
  if (new_curves && now_ms - curves_ms > kCurvesEvery_ms) {
    curves.update();
    new_curves = false;
    curves_ms = now_ms;
  }
  const frames_per_s = frames.count(begin_ms, drew);
  if (frames_per_s !== null) stage?.pace(frames_per_s);
}

function show_status(): void {
  if (timeline.live.newest === undefined) return;
  if (link === 'live' || commission?.is_over) status.update(timeline.live.newest);
  else status.update_unknown();
}

function show_readings(state: State): void {
  new_text = false;
  status.update_readings(state, started?.objects.map((object) => object.name) ?? [], (tip_m, object) => picture.way_out(tip_m, object));
  scrubber.min = timeline.least_offset_s.toFixed(2);
  scrubber.value = timeline.offset_s.toFixed(2);
  const when = timeline.paused ? `${timeline.offset_s.toFixed(2)} s` : 'live';
  set_text(element('when'), when);
  scrubber.setAttribute('aria-valuetext', timeline.paused ? `${(-timeline.offset_s).toFixed(1)} seconds ago` : 'live');
}

document.body.classList.remove('loading');
requestAnimationFrame(frame);
