// The task of the running scene: what is asked, that it is done, and the ghost that shows it.
import { element, set_text } from './dom';
import { Ghost } from './ghost';
import { HandPath } from './hand_path';
import type { State } from './protocol';
import { TaskWatch } from './task_watch';
import { kTasks } from './tasks';
import type { DoneTasks } from './tasks_done';
import type { SceneGallery } from './transport';
import type { Vec3 } from './vector';

const kBetweenStates_s = 0.02;
const kSettle_s = 0.5; // of the hand, after the ghost

type Hand = (arm: number, position_m: Vec3) => void;

export class TaskPanel {
  private readonly button = element<HTMLButtonElement>('show-me');
  private scene = '';
  private objects: readonly string[] = [];
  private watch: TaskWatch | null = null;
  private path: HandPath | null = null;
  private ghost: Ghost | null = null;
  private state: State | null = null;
  private state_at_s = 0;
  private device_s = 0; // its clock: it stands still while ticks are lost
  private settled_s = 0; // from then on it is the user's hand
  private may_lead = false;

  constructor(
    private readonly gallery: SceneGallery,
    private readonly done: DoneTasks,
    private readonly hand: Hand,
    private readonly on_done: () => void,
  ) {
    this.button.addEventListener('click', () => (this.ghost === null ? this.begin_ghost() : this.end_ghost()));
  }

  // may_lead: the hand is simulated, and this page may move it.
  allow(may_lead: boolean): void {
    this.may_lead = may_lead;
    if (!may_lead) this.end_ghost();
  }

  async begin(scene: string, objects: readonly string[]): Promise<void> {
    this.end_ghost();
    this.scene = scene;
    this.objects = objects;
    this.path = null;
    this.begin_watch();
    this.show();
    const csv = await this.gallery.hand_path(scene).catch(() => null);
    if (this.scene === scene && csv !== null) this.path = HandPath.parse(csv);
  }

  take(state: State): void {
    const now_s = performance.now() / 1000;
    const ticks = (state.tick ?? 0) - (this.state?.tick ?? 0);
    this.device_s += ticks > 0 && state.tick_rate_Hz ? ticks / state.tick_rate_Hz : Math.min(now_s - this.state_at_s, kBetweenStates_s);
    this.state = state;
    this.state_at_s = now_s;
    this.button.disabled = !this.may_lead || this.path === null || state.mode !== 'armed';
    if (state.mode !== 'armed') this.end_ghost();
    if (this.ghost !== null || now_s < this.settled_s || this.watch === null || this.watch.done) return;
    const met = this.watch.goals_met;
    this.watch.take(state);
    if (this.watch.done) {
      this.done.add(this.scene);
      this.on_done();
    }
    if (this.watch.goals_met !== met) this.show();
  }

  // Once a frame.
  step(now_s: number): void {
    if (this.ghost === null || this.state === null) return;
    const device_s = this.device_s + Math.min(now_s - this.state_at_s, kBetweenStates_s);
    const hands_m = this.state.arms.map((arm): Vec3 => arm?.hand_m ?? arm?.tip_m ?? [0, 0, 0]);
    if (!this.ghost.step(device_s, hands_m)) this.end_ghost();
  }

  // Also where the user takes the hand. What the ghost has done is not done.
  end_ghost(): void {
    if (this.ghost === null) return;
    this.ghost = null;
    this.settled_s = performance.now() / 1000 + kSettle_s;
    this.button.setAttribute('aria-pressed', 'false');
    this.begin_watch();
    this.show();
  }

  private begin_ghost(): void {
    if (this.path === null) return;
    this.ghost = new Ghost(this.path, kTasks[this.scene]?.shown_s ?? Infinity, this.hand);
    this.button.setAttribute('aria-pressed', 'true');
    this.show();
  }

  private begin_watch(): void {
    const task = kTasks[this.scene];
    this.watch = task === undefined ? null : new TaskWatch(task, this.objects);
  }

  private show(): void {
    const task = kTasks[this.scene];
    const is_done = this.watch?.done === true;
    const count = task !== undefined && task.goals.length > 1 && this.watch ? ` (${this.watch.goals_met} of ${task.goals.length})` : '';
    set_text(element('task-mark'), this.ghost ? 'Watch:' : is_done ? '✓ Done:' : 'Task:');
    element('task-mark').className = is_done ? 'good' : '';
    set_text(element('task-text'), task === undefined ? 'Explore.' : `${task.task}${this.ghost ? '' : count}`);
    set_text(this.button, this.ghost ? 'Let me' : 'Show me');
  }
}
