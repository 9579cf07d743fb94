// A hand on a spring, a tip at its end, surfaces that push it out: near enough to the simulated arm for a page to be seen at work.
import type { ArmState, Material, State } from '../src/protocol';
import type { SceneModel } from '../src/scene_image';
import { type Vec3, length, scale, sub } from '../src/vector';
import { type Surface, on_surface, surface_of } from './shapes';

const kHandStiffness_N_m = 250;
const kWorkspace_m: Vec3 = [0.19, 0.095, 0.13]; // to either side
const kMaxForce_N = 8;
const kRecovery_s = 0.6;
const kVolumes = new Set(['needle', 'tissue', 'vector_field', 'potential_field', 'force_field']);

interface Arm {
  hand: Vec3;
  tip: Vec3;
  inside: number[] | null; // null: to be found when it is armed
  state: ArmState;
}

export class Touch {
  mode = 'disarmed';
  stopped_by?: string;
  stopped_by_text?: string;
  worst_tick_s = 12.3e-6;
  fault = 0;
  fault_name = '';
  time_s = 0;
  materials: Material[];
  private homed = false;
  private clamped = false;
  private arms: Arm[];
  private tissues = new Map<number, NonNullable<State['tissues']>[number]>();
  private bodies: Map<number, Vec3>;

  constructor(
    readonly scene: SceneModel,
    arms: number,
  ) {
    this.materials = scene.objects.map((object) => ({ ...object.material }));
    this.bodies = new Map(scene.objects.flatMap((object, i) => (object.moves && !object.control ? [[i, object.position_m] as const] : [])));
    this.arms = Array.from({ length: arms }, (_, i) => {
      const at: Vec3 = arms === 1 ? [0, 0, 0] : [i === 0 ? -0.06 : 0.06, 0, 0];
      return { hand: at, tip: at, inside: null, state: { tip_m: at } };
    });
  }

  move_hand(arm: number, to: Vec3): void {
    const it = this.arms[arm];
    if (it) it.hand = to.map((value, i) => Math.min(Math.max(value, -kWorkspace_m[i]), kWorkspace_m[i])) as unknown as Vec3;
  }

  // Null, or why not.
  command(verb: string): string | null {
    if (verb === 'stop') {
      this.trip(14, 'host_stop');
      return null;
    }
    if (verb === 'home' && this.mode === 'disarmed') this.homed = true;
    if (verb === 'clear' && this.mode === 'faulted') this.fault = 0;
    if (verb === 'arm' && (!this.homed || this.fault !== 0)) return this.fault !== 0 ? 'faulted' : 'not_homed';
    this.stopped_by = verb === 'arm' ? undefined : this.mode === 'armed' ? 'disarm' : this.stopped_by;
    this.stopped_by_text = verb === 'arm' ? undefined : this.mode === 'armed' ? 'a host disarmed it' : this.stopped_by_text;
    this.mode = verb === 'arm' ? 'armed' : this.fault !== 0 ? 'faulted' : this.homed ? 'ready' : 'disarmed';
    return null;
  }

  trip(number: number, name: string): void {
    this.fault = number;
    this.fault_name = name;
    this.mode = 'faulted';
  }

  step(dt_s: number): void {
    this.time_s += dt_s;
    this.clamped = false;
    for (const tissue of this.tissues.values()) {
      tissue.pressed = false;
      tissue.depth_m *= Math.exp(-dt_s / kRecovery_s);
    }
    this.arms.forEach((arm, i) => this.step_arm(arm, i, dt_s));
  }

  // Springs of hand and surface in balance: the tip is between the surface and the hand.
  private step_arm(arm: Arm, number: number, dt_s: number): void {
    let tip = arm.hand;
    let god = tip;
    let force: Vec3 = [0, 0, 0];
    let energy_J = 0;
    const planes: { normal: Vec3 }[] = [];
    if (this.mode !== 'armed') arm.inside = null;
    else {
      const holds = (index: number): boolean =>
        !kVolumes.has(this.scene.objects[index].shape.kind) && this.surface(index, arm.hand).distance_m < 0;
      arm.inside = (arm.inside ?? [...this.scene.objects.keys()]).filter(holds);
      this.scene.objects.forEach((object, index) => {
        const surface = this.surface(index, arm.hand);
        if (surface.distance_m >= 0 || planes.length > 0 || arm.inside?.includes(index)) return;
        const stiffness = this.materials[index].stiffness;
        const depth_m = (-surface.distance_m * kHandStiffness_N_m) / (kHandStiffness_N_m + stiffness);
        god = on_surface(arm.hand, surface);
        tip = sub(god, scale(surface.normal, depth_m));
        const size_N = stiffness * depth_m;
        if (size_N > kMaxForce_N) this.clamped = true;
        force = scale(surface.normal, Math.min(size_N, kMaxForce_N));
        energy_J = -0.5 * stiffness * depth_m * depth_m;
        planes.push({ normal: surface.normal });
        if (object.shape.kind === 'tissue') {
          const at = sub(tip, object.position_m);
          this.tissues.set(number, { object: index, arm: number, pressed: true, at_m: [at[0], at[1]], depth_m });
        }
      });
    }
    const velocity = scale(sub(tip, arm.tip), 1 / dt_s);
    arm.tip = tip;
    arm.state = {
      tip_m: tip,
      god_m: god,
      force_N: force,
      velocity_m_s: length(velocity) < 10 ? velocity : [0, 0, 0],
      contacts: planes.length,
      planes,
      inside: arm.inside ?? [],
      hand_m: arm.hand,
      links_m: [[[tip[0], 0.2, 0.1], [tip[0], 0.1, 0.15], tip]],
      energy_J,
    };
  }

  private surface(index: number, at: Vec3): Surface {
    const object = this.scene.objects[index];
    return surface_of(object, this.bodies.get(index) ?? object.position_m, object.rotation, at);
  }

  state(simulated: boolean): State {
    return {
      type: 'state',
      time_s: this.time_s,
      tick: Math.round(this.time_s * 4000),
      mode: this.mode,
      stopped_by: this.stopped_by,
      stopped_by_text: this.stopped_by_text,
      fault: this.fault,
      fault_name: this.fault_name,
      limiters: this.clamped ? ['clamp'] : [],
      tick_rate_Hz: 4000,
      worst_tick_s: this.worst_tick_s,
      arms: this.arms.map(({ state }) => (simulated ? state : { ...state, hand_m: undefined })),
      bodies: [...this.bodies].map(([object, position_m]) => ({ object, position_m, rotation: this.scene.objects[object].rotation })),
      controls: this.scene.objects.flatMap((it, object) => (it.control ? [{ object, q: 0, on: false }] : [])),
      tissues: [...this.tissues.values()].map((it) => ({ ...it })),
      needles: this.needles(),
    };
  }

  private needles(): State['needles'] {
    const object = this.scene.objects.findIndex((it) => it.shape.kind === 'needle');
    if (object < 0) return [];
    return this.arms.map(({ tip }, arm) => {
      const at = sub(tip, this.scene.objects[object].position_m);
      return { object, arm, inside: at[2] < 0, at_m: [at[0], at[1]] as const, depth_m: Math.max(-at[2], 0), torn: 0 };
    });
  }
}
