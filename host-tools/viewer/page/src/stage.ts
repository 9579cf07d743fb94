// Canvas, camera, light: where the scene is shown. Right drag or shift + drag turns the view, ctrl + wheel comes nearer.
import {
  Box3,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  MOUSE,
  MathUtils,
  PCFShadowMap,
  PerspectiveCamera,
  Scene,
  Sphere,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

import type { View } from './drag_mapping';
import { kFieldOfView_deg, kSeat, pixel_m_at, view_of } from './framing';
import type { Vec3 } from './vector';

// Where frames come more slowly than this for two seconds, the picture gets coarser, down to the least pixel ratio.
const kSlow_per_s = 24;
const kLeastPixelRatio = 0.5;

const kStill_ms = 400; // what does not change for so long is drawn once more, as fine as it can be
const kVisible_px = 1 / 8;
const kLightFrom = new Vector3(-0.35, -0.45, 1).normalize();
const kShadowPixels = 1024;
// Planes fade into the background, in distances from the camera to what it looks at.
const kFogFrom = 1.3;
const kFogTo = 3.2;

export type Turn = 'left' | 'right' | 'up' | 'down' | 'nearer' | 'farther';

interface Quality {
  ratio: number; // pixels of the picture to a pixel of the page
  shadows: boolean;
}

const full_ratio = (): number => Math.min(devicePixelRatio, 2);

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(kFieldOfView_deg, 1, 0.005, 20);
  private readonly light_of_view = new DirectionalLight(0xffffff, 0.6);
  private readonly sun = new DirectionalLight(0xffffff, 1.5);
  private readonly fog = new Fog(0);
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private framed = new Box3();
  private first_m = 1; // from the camera to what it looks at, as the scene was framed
  private slow_s = 0;
  private quality: Quality;
  private waiting = true; // something changed since the last render
  private changed_ms = 0;
  private fine = true; // the last render was as fine as it can be

  // Throws where the browser has no WebGL 2.
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.quality = this.first_quality();
    this.camera.up.set(0, 0, 1);
    this.light_of_view.position.set(0.3, 0.8, 1);
    this.camera.add(this.light_of_view);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(kShadowPixels, kShadowPixels);
    this.sun.shadow.normalBias = 0.0006;
    this.sun.shadow.radius = 2;
    const sky = new HemisphereLight(0xffffff, 0x9a9aa2, 1.2);
    sky.position.copy(this.camera.up);
    this.scene.add(this.camera, this.sun, this.sun.target, sky);
    this.scene.fog = this.fog;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomSpeed = 1.5;
    this.controls.minDistance = 0.03;
    this.controls.maxDistance = 4;
    this.controls.addEventListener('change', () => this.touch());
    this.drag_turns(true);
    this.frame(new Box3(new Vector3(-0.06, -0.06, -0.06), new Vector3(0.06, 0.06, 0.06)));
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.read_theme();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.read_theme());
  }

  // Whether a plain left drag turns the view; else it is for the hand, and shift + drag turns. OrbitControls turns on a drag
  // that pans when shift is held.
  drag_turns(yes: boolean): void {
    this.controls.mouseButtons = { LEFT: yes ? MOUSE.ROTATE : MOUSE.PAN, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.ROTATE };
  }

  // The view stays as it is, whatever the mouse does.
  hold(yes: boolean): void {
    this.controls.enabled = !yes;
  }

  touch(): void {
    this.waiting = true;
  }

  // Whether the next render draws a changed picture.
  get is_touched(): boolean {
    return this.waiting;
  }

  // Draws if anything changed, as finely as the machine keeps up with; and once more, finely, when nothing has changed for a while.
  // False: nothing was drawn.
  render(now_ms: number): boolean {
    if (this.waiting) {
      this.waiting = false;
      this.changed_ms = now_ms;
      this.draw(this.quality);
    } else if (!this.fine && now_ms - this.changed_ms > kStill_ms) {
      this.draw({ ratio: full_ratio(), shadows: true });
    } else {
      return false;
    }
    return true;
  }

  private draw(quality: Quality): void {
    this.fine = quality.shadows && quality.ratio === full_ratio();
    if (this.renderer.getPixelRatio() !== quality.ratio) this.renderer.setPixelRatio(quality.ratio);
    this.sun.castShadow = quality.shadows;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.fog.near = kFogFrom * distance;
    this.fog.far = kFogTo * distance;
    this.renderer.render(this.scene, this.camera);
    this.canvas.dataset.ratio = String(quality.ratio);
  }

  // Looks at a box from the user's seat, from so far that all of it is seen.
  frame(box: Box3): void {
    this.framed = box.clone();
    this.quality = this.first_quality();
    const ball = box.getBoundingSphere(new Sphere());
    const reach = 1.3 * ball.radius;
    this.sun.target.position.copy(ball.center);
    this.sun.position.copy(ball.center).addScaledVector(kLightFrom, 2 * reach);
    Object.assign(this.sun.shadow.camera, { left: -reach, right: reach, bottom: -reach, top: reach, near: 0.1 * reach, far: 4 * reach });
    this.sun.shadow.camera.updateProjectionMatrix();
    this.reset();
  }

  reset(): void {
    const { target, distance_m } = view_of(this.framed, this.camera.aspect);
    this.first_m = distance_m;
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(kSeat, distance_m);
    this.controls.update();
    this.touch();
  }

  // Turns the view by buttons, without a mouse.
  turn(how: Turn): void {
    const from = new Vector3().subVectors(this.camera.position, this.controls.target);
    // Spherical counts its polar angle from y; the scene's up is z.
    const spherical = new Spherical().setFromVector3(new Vector3(from.x, from.z, -from.y));
    const step = MathUtils.degToRad(15);
    if (how === 'left') spherical.theta -= step;
    if (how === 'right') spherical.theta += step;
    if (how === 'up') spherical.phi -= step;
    if (how === 'down') spherical.phi += step;
    if (how === 'nearer') spherical.radius /= 1.25;
    if (how === 'farther') spherical.radius *= 1.25;
    spherical.makeSafe();
    from.setFromSpherical(spherical);
    this.camera.position.copy(this.controls.target).add(new Vector3(from.x, -from.z, from.y));
    this.controls.update();
    this.touch();
  }

  // Less than a change of this length is not seen.
  get least_visible_m(): number {
    return kVisible_px * this.view().pixel_m;
  }

  // The length of a pixel of the screen as far away as `at`.
  pixel_m(at: Vec3): number {
    const away = this.camera.getWorldDirection(new Vector3());
    return pixel_m_at(Math.max(new Vector3(...at).sub(this.camera.position).dot(away), this.camera.near), this.canvas.clientHeight);
  }

  // Directions of the screen in the world, and lengths at what the camera looks at.
  view(): View {
    this.camera.updateMatrixWorld();
    const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, back);
    const distance_m = this.camera.position.distanceTo(this.controls.target);
    return {
      right: right.toArray() as Vec3,
      up: up.toArray() as Vec3,
      away: back.negate().toArray() as Vec3,
      pixel_m: pixel_m_at(distance_m, this.canvas.clientHeight),
      zoom: distance_m / this.first_m,
    };
  }

  // A browser that has no graphics processor says so, and begins where pace() would come to.
  private first_quality(): Quality {
    const gl = this.renderer.getContext();
    const name = gl.getExtension('WEBGL_debug_renderer_info')?.UNMASKED_RENDERER_WEBGL;
    const software = name !== undefined && /swiftshader|llvmpipe|software/i.test(String(gl.getParameter(name)));
    return software ? { ratio: 0.7 * full_ratio(), shadows: false } : { ratio: full_ratio(), shadows: true };
  }

  // Once a second while every frame is drawn. A machine without a graphics processor keeps up without shadows and with fewer pixels.
  pace(frames_per_s: number): void {
    this.slow_s = frames_per_s < kSlow_per_s ? this.slow_s + 1 : 0;
    const { ratio, shadows } = this.quality;
    if (this.slow_s < 2 || (!shadows && ratio <= kLeastPixelRatio)) return;
    this.slow_s = 0;
    this.quality = shadows ? { ratio, shadows: false } : { ratio: Math.max(ratio * 0.7, kLeastPixelRatio), shadows };
    this.touch();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    const was = this.camera.aspect;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (was === 1) this.reset();
    this.touch();
  }

  private read_theme(): void {
    const background = new Color(getComputedStyle(this.canvas).getPropertyValue('--view').trim());
    this.scene.background = background;
    this.fog.color = background;
    this.touch();
  }
}
