// What goes beyond seeing: sound, vibration, and where there are scenes to choose from, the gallery with its tasks.
import type { Alerts } from './alerts';
import { element } from './dom';
import type { Hello, State } from './protocol';
import { SoundButton, why_silent } from './sound_button';
import type { Transport } from './transport';
import { Vibration, can_shake } from './vibration';

export class Extras {
  private readonly sound: SoundButton;
  private readonly vibration = new Vibration(navigator);
  private states = 0;
  private since_s: number | null = null;
  private forces_Hz = 0;

  constructor(
    private readonly transport: Transport,
    alerts: Alerts,
  ) {
    this.sound = new SoundButton((port) => transport.listen?.(port), alerts);
    this.show_vibration();
    addEventListener('gamepadconnected', () => this.show_vibration());
    addEventListener('gamepaddisconnected', () => this.show_vibration());
  }

  on_hello(hello: Hello): void {
    const every_tick = this.transport.listen !== undefined && hello.simulated;
    this.sound.allow(() => why_silent(every_tick, this.forces_Hz));
  }

  on_state(state: State): void {
    this.count(state.time_s);
    this.vibration.take(state, performance.now());
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
