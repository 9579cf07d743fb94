// The commissioning of an arm: its steps, the prompt of the moment and its buttons, and the marks in the picture.
import { Box3, Vector3 } from 'three';

import { AxisMarks } from './axis_marks';
import { element, make, set_text } from './dom';
import type { CommissionState, Hello, PageMessage, State } from './protocol';
import type { Stage } from './stage';
import type { Vec3 } from './vector';

// A button that is pressed twice must not answer the next prompt, which nobody has read.
export const kUnread_ms = 500;

// Whether a press of a button is an answer to the prompt that is shown.
export const may_answer = (shown_ms: number, now_ms: number): boolean => now_ms - shown_ms >= kUnread_ms;

// What stands in the place of the prompt.
export function prompt_text({ prompt, doing, over }: CommissionState): string {
  return over?.text ?? prompt?.text ?? (doing || 'Nothing to do: the step is being judged.');
}

// The marks of the picture in words.
export function picture_text({ axis, turn, way, goal_m, is_live, over }: CommissionState): string {
  if (over) return '';
  const parts: string[] = [];
  if (axis) parts.push(`The axis in question is ${axis.name}; its arrow is the positive direction.`);
  if (turn || way) parts.push('The orange arrow is the way to go first.');
  if (goal_m) parts.push('The green lines are where the arm is to be.');

  parts.push(is_live ? 'The arm is where its counters say.' : 'The arm is drawn at home: where it is is not known yet.');
  return parts.join(' ');
}

const kStateTexts = { 'not yet': 'not yet', now: 'now', passed: 'passed', found: 'not passed' };

export class CommissionView {
  private readonly marks = new AxisMarks();
  private readonly rows: HTMLElement[] = [];
  private steps_shown = '';
  private readonly box = new Box3();
  private size_m = 0;
  private number = -1;
  private shown_ms = 0;
  private state: CommissionState | null = null;

  constructor(
    private readonly stage: Stage | null,
    private readonly canvas: HTMLCanvasElement,
    private readonly send: (message: PageMessage) => boolean,
  ) {
    stage?.scene.add(this.marks.group);
    element('answer-done').addEventListener('click', () => this.answer('done'));
    element('answer-decline').addEventListener('click', () => this.answer('decline'));
  }

  get is_over(): boolean {
    return this.state?.over !== undefined;
  }

  // The page has its server again, or for the first time.
  begin(hello: Hello): void {
    document.body.classList.add('commissioning');
    document.title = `Thimble: ${hello.device?.arm ?? 'arm'}`;
    this.canvas.setAttribute('aria-label', 'The arm in three dimensions');
    this.may_control = hello.may_control;
    set_text(element('device'), `commissioning of ${hello.device?.arm ?? 'an arm'}${hello.simulated ? ', simulated' : ''}`);
    element('readonly').hidden = hello.may_control;
    this.rows.length = 0;
    this.steps_shown = '';
    for (const { name, text } of hello.commission?.steps ?? []) {
      const row = make('li', {}, { testid: `step-${this.rows.length}` });
      const head = make('p');
      head.append(make('strong', { textContent: name }), ' ', make('span', { className: 'step-state' }));
      row.append(head, make('p', { className: 'muted small', textContent: text }), make('ul', { className: 'findings' }));
      this.rows.push(row);
    }
    element('steps').replaceChildren(...this.rows);
  }
  private may_control = false;

  update(state: State): void {
    const it = state.commission;
    if (it === undefined) return;
    this.state = it;
    this.show_steps(it);
    this.show_prompt(it);
    const arm = state.arms[0];
    if (arm === null || arm === undefined) return;
    this.frame([arm.tip_m, ...(arm.links_m ?? []).flat(), ...(it.goal_m ?? []).flat()]);
    if (this.marks.update(it, arm.tip_m, this.size_m)) this.stage?.touch();
    this.canvas.dataset.axis = it.axis?.name ?? '';
    this.canvas.dataset.way = it.way?.join(' ') ?? '';
    this.canvas.dataset.live = String(it.is_live);
  }

  private show_prompt(it: CommissionState): void {
    const { prompt } = it;
    if (prompt && prompt.number !== this.number) {
      this.number = prompt.number;
      this.shown_ms = performance.now();
    }
    set_text(element('prompt'), prompt_text(it));
    set_text(element('picture-text'), picture_text(it));
    element('commission-prompt').className = it.over ? (it.over.passed ? 'good' : 'bad') : prompt ? 'asks' : '';
    set_text(element('answer-done'), prompt?.done ?? 'Done');
    set_text(element('answer-decline'), prompt?.decline ?? 'Decline');
    // Not disabled: a button would lose the focus of the keyboard between two prompts.
    element('answer-done').setAttribute('aria-disabled', String(!prompt || !this.may_control));
    element('answer-decline').setAttribute('aria-disabled', String(!prompt || !this.may_control));
    element('answer-decline').hidden = prompt?.decline === undefined;
    element('answers').hidden = it.over !== undefined;
  }

  private show_steps(it: CommissionState): void {
    const text = JSON.stringify(it.steps);
    if (text === this.steps_shown) return;
    this.steps_shown = text;
    it.steps.forEach((step, i) => {
      const row = this.rows[i];
      if (row === undefined) return;
      row.dataset.state = step.state;
      if (step.state === 'now') row.setAttribute('aria-current', 'step');
      else row.removeAttribute('aria-current');
      set_text(row.querySelector<HTMLElement>('.step-state')!, kStateTexts[step.state]);
      row
        .querySelector('.findings')!
        .replaceChildren(
          ...step.findings.map(({ name, text }) => make('li', { className: 'bad', textContent: `${name}: ${text}` })),
          ...step.notes.map((note) => make('li', { className: 'muted', textContent: note })),
        );
    });
  }

  // Looks at the whole arm, and anew when it has left the picture.
  private frame(points: readonly Vec3[]): void {
    const all = points.map((point) => new Vector3(...point));
    if (all.length === 0 || all.every((point) => this.box.containsPoint(point))) return;
    this.box.setFromPoints(all);
    if (this.size_m === 0) this.size_m = Math.max(this.box.getSize(new Vector3()).length(), 0.05);
    this.box.expandByScalar(0.2 * this.size_m);
    this.stage?.frame(this.box);
  }

  private answer(answer: 'done' | 'decline'): void {
    const prompt = this.state?.prompt;
    if (!prompt || !this.may_control || !may_answer(this.shown_ms, performance.now())) return;
    this.send({ type: 'answer', prompt: prompt.number, answer });
  }
}
