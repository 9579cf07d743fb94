// The simulated hand by mouse, finger and keys: to the side and up and down (drag_mapping.ts), and in depth by wheel, two fingers,
// PageUp and PageDown. The hands of both arms can be moved together: what is held between them is lifted by that.
// It sends the wanted positions; the server keeps them inside the workspace and answers with hand_m.
import { type Axes, type Reach, drag_m_per_px, hand_axes, kNoReach } from './drag_mapping';
import type { Stage } from './stage';
import { type Vec3, add, length, scale, sub } from './vector';

const kWishes_per_s = 70; // the server takes 200 messages a second; displays draw up to 240 frames
const kKeyStep_m = 0.001;
const kKeySpeed_m_s = 0.04;
const kKeyHold_s = 0.25; // held for longer, a key moves the hand all the time
const kFine = 0.2; // with shift
const kWheel = 0.1; // of a drag as long: a notch, some 100 pixels, is a drag of 10
const kLinePixels = 16;
// How far a wish may be from where the server lets the hand be, so that it need not come back from far beyond the workspace.
const kLead_m = 0.08;

const kKeys: Record<string, Vec3> = {
  ArrowLeft: [-1, 0, 0],
  ArrowRight: [1, 0, 0],
  ArrowUp: [0, 1, 0],
  ArrowDown: [0, -1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
};

export class HandControl {
  arms: readonly number[] = [0]; // that are moved
  yields: () => boolean = () => false; // a press is for somebody else
  reaches: readonly Reach[] = []; // of each arm's home in the scene
  private enabled = false;
  private readonly wishes: (Vec3 | null)[] = []; // of each arm
  private unsent = false;
  private readonly known: (Vec3 | undefined)[] = []; // where the server says the hands are
  private pointers = new Map<number, { x: number; y: number }>();
  private held = new Map<string, number>(); // key: since when, in seconds
  private fine = false;
  private sent_s = -Infinity;
  private due_s = -Infinity;

  constructor(
    private readonly stage: Stage,
    private readonly send: (arm: number, position_m: Vec3) => void,
  ) {
    const canvas = stage.canvas;
    const first = { capture: true }; // before the camera's own listeners
    canvas.addEventListener('pointerdown', (event) => this.on_down(event), first);
    canvas.addEventListener('pointermove', (event) => this.on_move(event), first);
    canvas.addEventListener('pointerup', (event) => this.on_up(event), first);
    canvas.addEventListener('pointercancel', (event) => this.on_up(event), first);
    canvas.addEventListener('wheel', (event) => this.on_wheel(event), { capture: true, passive: false });
    canvas.addEventListener('keydown', (event) => this.on_key(event));
    canvas.addEventListener('keyup', (event) => this.held.delete(event.key));
    canvas.addEventListener('blur', () => this.held.clear());
  }

  enable(yes: boolean): void {
    this.enabled = yes;
    if (!yes) this.release();
    this.stage.drag_turns(!yes);
  }

  choose(arms: readonly number[]): void {
    this.arms = arms;
    this.release();
  }

  // Where the server says that the hand (or else the tip) of an arm is.
  follow(arm: number, position_m: Vec3): void {
    this.known[arm] = position_m;
    if (!this.busy) this.wishes[arm] = null;
  }

  // What the hand moves along; null: it cannot be moved.
  get axes(): Axes | null {
    return this.enabled ? hand_axes(this.stage.view(), this.reach) : null;
  }

  // Once a frame: held keys move the hand, and at most one position is sent.
  step(now_s: number, dt_s: number): void {
    if (!this.enabled) return;
    for (const [key, since_s] of this.held) {
      if (now_s - since_s > kKeyHold_s) this.move(kKeys[key], kKeySpeed_m_s * dt_s * (this.fine ? kFine : 1));
    }
    if (!this.unsent || now_s < this.due_s) return;
    // Keeps the average rate: a late frame does not delay the next position.
    this.due_s = Math.max(this.due_s + 1 / kWishes_per_s, now_s);
    this.unsent = false;
    for (const arm of this.arms) {
      const wish = this.wishes[arm];
      if (wish) this.send(arm, wish);
    }
    this.sent_s = now_s;
  }

  // The wheel and a tapped key have no end that could be waited for: a wish is kept until the server had time to answer.
  get busy(): boolean {
    return this.pointers.size > 0 || this.held.size > 0 || this.unsent || performance.now() / 1000 - this.sent_s < 0.3;
  }

  private release(): void {
    this.pointers.clear();
    this.held.clear();
    this.wishes.length = 0;
    this.unsent = false;
  }

  private get reach(): Reach {
    return this.reaches[this.arms[0]] ?? kNoReach;
  }

  // By `by_m` along a direction: right, up, away.
  private move([right, up, away]: Vec3, by_m: number): void {
    const { axes } = this;
    if (axes === null) return;
    const along = add(add(scale(axes.right, right), scale(axes.up, up)), scale(axes.away, away));
    const by = scale(along, by_m);
    if (this.arms.some((arm) => this.is_far(arm, by))) return; // together, or not at all
    for (const arm of this.arms) {
      const from = this.wishes[arm] ?? this.known[arm];
      if (from === undefined) continue;
      this.wishes[arm] = add(from, by);
      this.unsent = true;
    }
  }
  // The wish would go too far ahead of the hand, and farther than it is.
  private is_far(arm: number, by: Vec3): boolean {
    const [wish, known] = [this.wishes[arm], this.known[arm]];
    if (!wish || known === undefined) return false;
    const lead_m = length(sub(add(wish, by), known));
    return lead_m > kLead_m && lead_m > length(sub(wish, known));
  }

  private move_pixels(dx: number, dy: number, depth: boolean): void {
    this.move(depth ? [0, 0, -dy] : [dx, -dy, 0], drag_m_per_px(this.stage.view(), this.reach));
  }

  private on_down(event: PointerEvent): void {
    this.stage.canvas.focus({ preventScroll: true });
    if (!this.enabled || event.button !== 0 || event.shiftKey || this.yields()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  private on_move(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (before === undefined) return;
    event.stopImmediatePropagation();
    const fingers = this.pointers.size;
    this.move_pixels((event.clientX - before.x) / fingers, (event.clientY - before.y) / fingers, fingers > 1);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  private on_up(event: PointerEvent): void {
    if (this.pointers.delete(event.pointerId)) event.stopImmediatePropagation();
  }

  // Ctrl + wheel, which is also what a pinch on a touch pad sends, is left to the camera.
  private on_wheel(event: WheelEvent): void {
    if (!this.enabled || event.ctrlKey) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * kLinePixels;
    this.move_pixels(0, kWheel * pixels, true);
  }

  private on_key(event: KeyboardEvent): void {
    const direction = kKeys[event.key];
    if (!this.enabled || direction === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    this.fine = event.shiftKey;
    if (event.repeat) return;
    this.held.set(event.key, performance.now() / 1000);
    this.move(direction, kKeyStep_m * (this.fine ? kFine : 1));
  }
}
