// Phones vibrate and gamepads rumble where the force changes from one state of the telemetry to the next: at contacts, clicks and slips.
import type { State } from './protocol';
import { length, sub, type Vec3 } from './vector';

const kLeast_N = 0.15; // a change from one state to the next
const kFull_N = 1.5;
const kPulse_ms = 40; // of a gamepad, and the longest of a phone
const kPause_ms = 50;

// Of what a state changed against the one before, 0 to 1.
export class Transients {
  private before: Vec3[] = [];

  take(state: State): number {
    const forces = state.arms.map((arm): Vec3 => arm?.force_N ?? [0, 0, 0]);
    const change_N = Math.max(0, ...forces.map((force, arm) => (this.before[arm] ? length(sub(force, this.before[arm])) : 0)));
    this.before = forces;
    return change_N < kLeast_N ? 0 : Math.min(1, change_N / kFull_N);
  }
}

// Of the browser what is used here. Browsers of desks have vibrate() too, and nothing that vibrates.
export interface Shaken {
  readonly maxTouchPoints: number;
  vibrate?: (ms: number) => boolean;
  getGamepads?: () => (Gamepad | null)[];
}

const actuators = (it: Shaken): GamepadHapticActuator[] =>
  (it.getGamepads?.() ?? []).flatMap((pad) => (pad?.vibrationActuator ? [pad.vibrationActuator] : []));

export const can_shake = (it: Shaken): boolean => (it.vibrate !== undefined && it.maxTouchPoints > 0) || actuators(it).length > 0;

export class Vibration {
  on = false;
  private readonly transients = new Transients();
  private free_ms = 0;

  constructor(private readonly shaken: Shaken) {}

  take(state: State, now_ms: number): void {
    const strength = this.transients.take(state);
    if (!this.on || strength === 0 || now_ms < this.free_ms) return;
    this.free_ms = now_ms + kPause_ms;
    this.shaken.vibrate?.(Math.ceil(kPulse_ms * strength)); // a phone knows no strength: a stronger pulse is a longer one
    for (const actuator of actuators(this.shaken))
      void actuator
        .playEffect('dual-rumble', { duration: kPulse_ms, strongMagnitude: strength, weakMagnitude: strength / 2 })
        .catch(() => {}); // it is gone
  }
}
