// The button that switches the sound on. Where the device does not tell the force of every tick it says why there is none.
import type { Alerts } from './alerts';
import { element } from './dom';
import type { Sound } from './sound';

const kLeast_Hz = 2000; // forces: twice what is to be heard of them

// Why these forces are no sound; null: they are.
export function why_silent(every_tick: boolean, forces_Hz: number): string | null {
  if (every_tick) return null;
  return `this device tells ${Math.round(forces_Hz)} forces a second, and sound needs ${kLeast_Hz}: the one in a page tells every tick`;
}

export class SoundButton {
  private readonly button = element<HTMLButtonElement>('sound');
  private sound: Sound | null = null;
  private why: () => string | null = () => 'no device has answered yet';

  // listen: the forces of all ticks go to that port, or no more.
  constructor(
    private readonly listen: (port: MessagePort | null) => void,
    private readonly alerts: Alerts,
  ) {
    this.button.addEventListener('click', () => void (this.sound === null ? this.switch_on() : this.switch_off()));
  }

  allow(why: () => string | null): void {
    this.why = why;
    if (why() !== null) this.switch_off();
  }

  private async switch_on(): Promise<void> {
    const why = this.why();
    if (why !== null) return this.refuse(why, 'open the device in the page (docs/in-a-page.md)');
    try {
      const { Sound } = await import('./sound');
      if (this.sound !== null) return;
      const sound = new Sound(({ peak, gaps }) => Object.assign(this.button.dataset, { peak: peak.toFixed(4), gaps: `${gaps}` }));
      this.sound = sound;
      this.button.setAttribute('aria-pressed', 'true');
      const port = await sound.open();
      if (port !== null) this.listen(port);
    } catch (error) {
      this.switch_off();
      this.refuse(error instanceof Error ? error.message : String(error), 'use another browser; the rest works');
    }
  }

  private switch_off(): void {
    if (this.sound === null) return;
    this.listen(null);
    this.sound.close();
    this.sound = null;
    this.button.setAttribute('aria-pressed', 'false');
    delete this.button.dataset.peak;
  }

  private refuse(cause: string, remedy: string): void {
    this.alerts.say({ level: 'error', name: 'no-sound', cause, remedy });
  }
}
