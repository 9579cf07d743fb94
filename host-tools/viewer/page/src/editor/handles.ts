// The selected object in the view: handles to move, turn and scale it by, and what a click selects.
import { Box3, Box3Helper, Color, Euler, MathUtils, Object3D, Raycaster, Vector2 } from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';

import type { SceneObjects } from '../scene_objects';
import type { Stage } from '../stage';
import type { Vec3 } from '../vector';

export type Way = 'translate' | 'rotate' | 'scale';

export interface Pose {
  position_m: Vec3;
  rotation_deg: Vec3; // about x, then y, then z, fixed axes
}

export interface HandleListener {
  picked(object: number | null): void;
  began(): void;
  dragged(way: Way, pose: Pose, factors: Vec3): void;
  ended(): void;
}

const kClick_px = 4;
const kSnapTurn_deg = 15;
const kSnapScale = 0.1;
const kLeastScale = 0.01;
const kOrder = 'ZYX'; // of three.js, for fixed axes x, y, z

export class Handles {
  private readonly proxy = new Object3D();
  private readonly controls: TransformControls;
  private readonly outline = new Box3Helper(new Box3(), new Color(0xff7a00));
  private objects: SceneObjects | null = null;
  private selected: number | null = null;
  private pressed: { x: number; y: number } | null = null;
  private readonly listening = new AbortController();

  constructor(
    private readonly stage: Stage,
    private readonly listener: HandleListener,
  ) {
    this.controls = new TransformControls(stage.camera, stage.canvas);
    this.controls.setSize(0.8);
    this.outline.visible = false;
    stage.scene.add(this.proxy, this.controls.getHelper(), this.outline);
    this.controls.addEventListener('change', () => stage.touch());
    this.controls.addEventListener('axis-changed', ({ value }) => this.point_out(value as string | null));
    this.controls.addEventListener('dragging-changed', ({ value }) => stage.hold(value === true));
    this.controls.addEventListener('mouseDown', () => this.listener.began());
    this.controls.addEventListener('objectChange', () => this.drag());
    this.controls.addEventListener('mouseUp', () => this.end());
    // Before those of the canvas: a press there may be for the hand alone.
    const around = stage.canvas.parentElement as HTMLElement;
    const how = { capture: true, signal: this.listening.signal };
    around.addEventListener('pointerdown', (event) => this.press(event), how);
    around.addEventListener('pointerup', (event) => this.release(event), how);
  }

  // Whether the mouse is at a handle.
  get is_wanted(): boolean {
    return this.controls.axis !== null || this.controls.dragging;
  }
  get is_dragging(): boolean {
    return this.controls.dragging;
  }

  set way(way: Way) {
    this.controls.setMode(way);
    this.controls.setSpace(way === 'translate' ? 'world' : 'local');
    this.stage.touch();
  }

  // null: no grid.
  snap(grid_m: number | null): void {
    this.controls.setTranslationSnap(grid_m);
    this.controls.setRotationSnap(grid_m === null ? null : MathUtils.degToRad(kSnapTurn_deg));
    this.controls.setScaleSnap(grid_m === null ? null : kSnapScale);
  }

  show(objects: SceneObjects | null): void {
    this.objects = objects;
    this.mark();
  }

  select(object: number | null, pose: Pose | null): void {
    if (this.controls.dragging) return;
    this.selected = pose === null ? null : object;
    if (pose === null) this.controls.detach();
    else {
      this.put(pose);
      this.controls.attach(this.proxy);
    }
    this.mark();
  }

  destroy(): void {
    this.listening.abort();
    this.controls.detach();
    this.controls.dispose();
    this.stage.scene.remove(this.proxy, this.controls.getHelper(), this.outline);
    this.point_out(null);
    this.stage.hold(false);
    this.stage.touch();
  }

  private put({ position_m, rotation_deg }: Pose): void {
    const [x, y, z] = rotation_deg.map((angle) => MathUtils.degToRad(angle));
    this.proxy.position.set(...position_m);
    this.proxy.quaternion.setFromEuler(new Euler(x, y, z, kOrder));
    this.proxy.scale.set(1, 1, 1);
  }

  private mark(): void {
    const group = this.selected === null ? undefined : this.objects?.group.children[this.selected];
    const plane = this.selected !== null && this.objects?.model.objects[this.selected]?.shape.kind === 'plane';
    this.outline.visible = group !== undefined && !plane;
    if (group !== undefined) this.outline.box.setFromObject(group);
    this.tell_place();
    this.stage.touch();
  }

  // Where the handles are in the picture, for tests.
  private tell_place(): void {
    const { canvas, camera } = this.stage;
    camera.updateMatrixWorld();
    const { x, y } = this.proxy.position.clone().project(camera);
    const pixels = [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight];
    canvas.dataset.handles = this.selected === null ? '' : pixels.map((at) => at.toFixed(1)).join(' ');
  }

  // The handle at the mouse, for the cursor and for tests.
  private point_out(axis: string | null): void {
    const { canvas } = this.stage;
    canvas.style.cursor = axis === null ? '' : 'grab';
    if (axis === null) delete canvas.dataset.handle;
    else canvas.dataset.handle = axis;
  }

  private drag(): void {
    const { position, quaternion, scale } = this.proxy;
    const turned = new Euler().setFromQuaternion(quaternion, kOrder);
    const rotation_deg: Vec3 = [MathUtils.radToDeg(turned.x), MathUtils.radToDeg(turned.y), MathUtils.radToDeg(turned.z)];
    const least = (factor: number) => Math.max(Math.abs(factor), kLeastScale);
    const factors: Vec3 = [least(scale.x), least(scale.y), least(scale.z)];
    // What is dragged is seen at once; the scene's own picture follows.
    const group = this.selected === null ? undefined : this.objects?.group.children[this.selected];
    group?.position.copy(position);
    group?.quaternion.copy(quaternion);
    group?.scale.set(...factors);
    this.mark();
    this.listener.dragged(this.controls.mode as Way, { position_m: position.toArray() as Vec3, rotation_deg }, factors);
  }
  private end(): void {
    this.proxy.scale.set(1, 1, 1);
    this.listener.ended();
  }

  private press(event: PointerEvent): void {
    const plain = event.button === 0 && !event.shiftKey && event.target === this.stage.canvas && this.controls.axis === null;
    this.pressed = plain ? { x: event.clientX, y: event.clientY } : null;
  }
  private release(event: PointerEvent): void {
    const from = this.pressed;
    this.pressed = null;
    if (from === null || Math.hypot(event.clientX - from.x, event.clientY - from.y) > kClick_px) return;
    this.listener.picked(this.object_at(event));
  }

  private object_at({ clientX, clientY }: PointerEvent): number | null {
    const box = this.stage.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.stage.camera);
    const met = this.objects?.surfaces.along(ray.ray.origin.toArray() as Vec3, ray.ray.direction.toArray() as Vec3, true);
    return met?.object ?? null;
  }
}
