// What went wrong, where it is seen: a banner over the page for each refusal and fault, the newest first, until it is dismissed or over.
// The list of messages keeps all of them.
import { element, make, set_text } from './dom';
import { type SceneStarted, type ServerEvent, type State, is_unknown } from './protocol';
import { on_this_page } from './remedies';

const kMessages = 100;
const kAsked_ms = 3000; // after something that the user asked for, that the arm is disarmed is no news

const narrow = matchMedia('(max-width: 600px)'); // as in alerts.css
const most_shown = (): number => (narrow.matches ? 1 : 3); // the picture stays in view

export type Event = Omit<ServerEvent, 'type'>;

interface Entry {
  event: Event;
  times: number;
  until: 'dismissed' | 'cleared' | 'armed' | 'other scene';
  line: HTMLElement;
}

// Refusals of the page's own, or what the state alone tells: an event of the server has better words.
const fault_event = (name: string): Event => ({
  level: 'error',
  name,
  cause: 'the controller is stopped by this fault',
  remedy: 'end its cause, then clear the fault',
});
const stop_event = (name: string, cause: string): Event => ({ level: 'error', name, cause, remedy: 'arm again when the hand is ready' });

const unknown_scene = (name: string): Event => ({
  level: 'error',
  name: 'scene-unknown',
  cause: `the device runs "${name}", a scene that is not known here, so the arm and its forces are shown without the objects`,
  remedy: 'load that scene here to see it, or another one in its place',
});

export class Alerts {
  private entries: Entry[] = []; // the newest first
  private fault: string | null = null;
  private stopped: string | null = null; // null: nothing is known yet
  private asked_ms = -Infinity;

  constructor(private readonly focus_next: () => void) {
    narrow.addEventListener('change', () => this.show());
  }

  say(told: Event): void {
    const event = told.remedy === undefined ? told : { ...told, remedy: on_this_page(told.remedy) };
    const list = element('messages');
    const line = make('li', { className: event.level });
    line.textContent = `${new Date().toLocaleTimeString()} ${event.name}: ${event.cause}${event.remedy ? ` - ${event.remedy}` : ''}`;
    list.prepend(line);
    while (list.children.length > kMessages) list.lastElementChild?.remove();
    const of_fault = event.name === this.fault || event.name === 'device-faulted';
    if (event.level === 'error') this.raise(event, of_fault ? 'cleared' : 'dismissed');
  }

  // The user has asked for something that may disarm the arm.
  asked(): void {
    this.asked_ms = performance.now();
  }

  // Another device, whose stop is no news.
  forget_device(): void {
    this.stopped = null;
  }

  // Faults and stops, also those that no event has told.
  follow(state: State): void {
    const fault = state.fault ? state.fault_name || `fault ${state.fault}` : '';
    if (fault !== this.fault) {
      this.fault = fault;
      const told = this.entries.find(({ event }) => event.name === fault);
      if (told) told.until = 'cleared';
      else if (fault !== '') this.raise(fault_event(fault), 'cleared');
      this.drop((it) => it.until === 'cleared' && it.event.name !== fault);
    }
    const stopped = state.stopped_by ?? '';
    if (stopped === this.stopped) return;
    const news = this.stopped !== null && (stopped !== 'disarm' || performance.now() - this.asked_ms > kAsked_ms);
    this.stopped = stopped;
    this.drop((it) => it.until === 'armed');
    // A stop and a fault have a banner of their own.
    if (stopped !== '' && news && !['stop', 'fault'].includes(stopped))
      this.raise(stop_event(stopped, state.stopped_by_text ?? 'the arm is no longer armed'), 'armed');
  }

  // A page that comes late hears no event of it.
  follow_scene(scene: SceneStarted): void {
    this.drop((it) => it.until === 'other scene');
    if (is_unknown(scene) && !scene.sought) this.raise(unknown_scene(scene.name), 'other scene');
  }

  private raise(event: Event, until: Entry['until']): void {
    const same = this.entries.find((it) => it.event.name === event.name && it.event.cause === event.cause);
    this.drop((it) => it.event.name === event.name && (it === same || it.until === 'cleared'));
    const line = make('div', { className: 'alert' }, { testid: 'alert' });
    const entry: Entry = { event, times: (same?.times ?? 0) + 1, until, line };
    const words = make('p');
    words.append(make('strong', { textContent: event.name }), ` ${event.cause}.`.replace(/\.\.$/, '.'));
    if (entry.times > 1) words.append(make('span', { className: 'muted', textContent: ` ${entry.times} times` }));
    if (event.remedy) words.append(make('span', { className: 'remedy', textContent: event.remedy }));
    const button = make('button', { type: 'button', textContent: 'Dismiss' }, { testid: 'dismiss' });
    button.setAttribute('aria-label', `Dismiss ${event.name}`);
    button.addEventListener('click', () => this.dismiss(entry));
    line.append(words, button);
    this.entries.unshift(entry);
    element('alerts-list').prepend(line);
    this.show();
  }

  // The focus goes on to the next banner, or back to the page.
  private dismiss(entry: Entry): void {
    const at = this.entries.indexOf(entry);
    this.drop((it) => it === entry);
    const next = this.entries[Math.min(at, Math.min(this.entries.length, most_shown()) - 1)];
    if (next) next.line.querySelector('button')?.focus();
    else this.focus_next();
  }

  private drop(over: (entry: Entry) => boolean): void {
    for (const entry of this.entries.filter(over)) entry.line.remove();
    this.entries = this.entries.filter((entry) => !over(entry));
    this.show();
  }

  private show(): void {
    this.entries.forEach(({ line }, i) => (line.hidden = i >= most_shown()));
    const more = this.entries.length - most_shown();
    set_text(element('alerts-more'), more > 0 ? `${more} more: see Messages` : '');
  }
}
