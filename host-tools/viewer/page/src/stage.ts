// Canvas, camera, light: where the scene is shown. Right drag or shift + drag turns the view, ctrl + wheel comes nearer.
import {
  Box3,
  Color,
  DirectionalLight,
  HemisphereLight,
  MOUSE,
  MathUtils,
  PerspectiveCamera,
  Scene,
  Sphere,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

// From the user's seat, a little above and to the right.
const kFrom = new Vector3(0.3, -1, 0.55).normalize();

// Where frames come more slowly than this for two seconds, the picture gets coarser, down to the least pixel ratio.
const kSlow_per_s = 24;
const kLeastPixelRatio = 0.5;

// The box that is framed is seldom as large as the ball about it.
const kFill = 0.92;

export type Turn = 'left' | 'right' | 'up' | 'down' | 'nearer' | 'farther';

const full_ratio = (): number => Math.min(devicePixelRatio, 2);

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(40, 1, 0.005, 20);
  readonly light_of_view = new DirectionalLight(0xffffff, 1.6);
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private framed = new Sphere(new Vector3(), 0.12);
  private slow_s = 0;
  private waiting = true; // something changed since the last render

  // Throws where the browser has no WebGL 2.
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(full_ratio());
    this.camera.up.set(0, 0, 1);
    this.light_of_view.position.set(0.3, 0.8, 1);
    this.camera.add(this.light_of_view);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x888890, 1.5));
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

  touch(): void {
    this.waiting = true;
  }

  // Draws if anything changed. True when it did.
  render(): boolean {
    if (!this.waiting) return false;
    this.waiting = false;
    this.renderer.render(this.scene, this.camera);
    return true;
  }

  // Looks at a box from the user's seat, from so far that all of it is seen.
  frame(box: Box3): void {
    box.getBoundingSphere(this.framed);
    this.renderer.setPixelRatio(full_ratio());
    this.reset();
  }

  reset(): void {
    const half = MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    this.controls.target.copy(this.framed.center);
    this.camera.position.copy(this.framed.center).addScaledVector(kFrom, (kFill * this.framed.radius) / Math.sin(narrow));
    this.controls.update();
    this.touch();
  }

  // The view by buttons, for those without a mouse.
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

  // Directions of the screen in the world, and the length of one of its pixels as far away as `at`.
  screen(at: Vector3): { right: Vector3; up: Vector3; away: Vector3; pixel_m: number } {
    this.camera.updateMatrixWorld();
    const right = new Vector3();
    const up = new Vector3();
    const back = new Vector3();
    this.camera.matrixWorld.extractBasis(right, up, back);
    const away = back.negate();
    const distance = Math.max(new Vector3().subVectors(at, this.camera.position).dot(away), this.camera.near);
    const pixel_m = (2 * distance * Math.tan(MathUtils.degToRad(this.camera.fov / 2))) / Math.max(this.canvas.clientHeight, 1);
    return { right, up, away, pixel_m };
  }

  // Once a second while frames are drawn. A machine without a graphics processor keeps up with fewer pixels.
  pace(frames_per_s: number): void {
    this.slow_s = frames_per_s < kSlow_per_s ? this.slow_s + 1 : 0;
    const ratio = this.renderer.getPixelRatio();
    if (this.slow_s < 2 || ratio <= kLeastPixelRatio) return;
    this.slow_s = 0;
    this.renderer.setPixelRatio(Math.max(ratio * 0.7, kLeastPixelRatio));
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
    this.scene.background = new Color(getComputedStyle(this.canvas).getPropertyValue('--view').trim());
    this.touch();
  }
}
