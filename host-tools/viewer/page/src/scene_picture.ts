// The scene that runs, in the picture: its objects and the marks of the arms. What tests read of it is in the canvas' data.
import { ArmMarks } from './arm_marks';
import type { Axes } from './drag_mapping';
import type { State } from './protocol';
import type { SceneModel } from './scene_image';
import { SceneObjects } from './scene_objects';
import type { Stage } from './stage';
import type { Vec3 } from './vector';
import { looks_same, visible } from './visible';
import { way_out } from './way_out';

export class ScenePicture {
  objects: SceneObjects | null = null;
  private model: SceneModel | null = null;
  private marks: ArmMarks[] = [];
  private drawn: number[] = []; // what is seen of the state that is drawn
  private is_new = false; // the state, since the last frame

  constructor(
    private readonly stage: Stage | null,
    private readonly canvas: HTMLCanvasElement,
  ) {}

  get arms(): number {
    return this.marks.length;
  }
  lay_out(arms: number): void {
    for (const mark of this.marks) mark.group.removeFromParent();
    this.marks = Array.from({ length: arms }, (_, arm) => new ArmMarks(arm));
    for (const mark of this.marks) this.stage?.scene.add(mark.group);
  }

  hide(): void {
    this.objects?.dispose();
    this.objects = this.model = null;
    delete this.canvas.dataset.objects;
    delete this.canvas.dataset.triangles;
    this.stage?.touch();
  }
  // look: the view is set to show all of it.
  show(model: SceneModel, arms: number, look: boolean): void {
    this.objects?.dispose();
    this.model = model;
    this.objects = this.stage === null ? null : new SceneObjects(model, arms);
    this.canvas.dataset.triangles = String(model.triangles);
    this.canvas.dataset.objects = String(model.objects.length);
    const names = model.objects.map((object) => object.name).join(', ');
    this.canvas.setAttribute('aria-label', `The scene in three dimensions: ${names}`);
    if (this.stage === null || this.objects === null) return;
    this.stage.scene.add(this.objects.group);
    if (look) this.stage.frame(this.objects.bounds);
    this.stage.touch();
    this.is_new = true;
  }

  on_state(): void {
    this.is_new = true;
  }

  // The hands of these arms are being moved along the axes; null: none is.
  show_moves(axes: Axes | null, arms: readonly number[]): void {
    this.marks.forEach((mark, arm) => {
      const now = arms.includes(arm) ? axes : null;
      if ((now === null) !== (mark.axes === null)) this.stage?.touch();
      mark.axes = now;
    });
  }

  // Draws if the state looks other than what is drawn, or if the view or the scene has changed. False: nothing was drawn.
  draw(now_ms: number, state: State | undefined): boolean {
    const { stage } = this;
    if (stage === null) return false;
    if (this.is_new && state !== undefined) {
      this.is_new = false;
      const now = visible(state);
      if (!looks_same(now, this.drawn, stage.least_visible_m)) {
        this.drawn = now;
        stage.touch();
      }
      this.canvas.dataset.tick = String(state.tick ?? '');
      this.canvas.dataset.sinceUs = String(state.since_us ?? '');
    }
    // Marks have a size on the screen, so they follow the camera too.
    if (stage.is_touched && state !== undefined) {
      const pixel_m = (at: Vec3): number => stage.pixel_m(at);
      this.objects?.update(state);
      for (const mark of this.marks) mark.update(state, this.model, this.objects?.surfaces ?? null, pixel_m);
      this.show_depth();
      this.canvas.dataset.links = String(this.marks.reduce((sum, mark) => sum + mark.shown_links, 0));
    }
    return stage.render(now_ms);
  }

  way_out(tip_m: Vec3, object: number): ReturnType<typeof way_out> {
    return way_out(this.objects?.surfaces ?? null, tip_m, object, this.model?.tip_radius_m ?? 0);
  }

  // Of the first arm.
  private show_depth(): void {
    const { clearance_m, nearest, below } = this.marks[0].depth;
    const name = (object: number | undefined) => (object === undefined ? '' : (this.model?.objects[object]?.name ?? ''));
    this.canvas.dataset.clearanceMm = clearance_m === null ? '' : (clearance_m * 1000).toFixed(2);
    this.canvas.dataset.nearest = name(nearest?.object);
    this.canvas.dataset.below = name(below?.object);
  }
}
