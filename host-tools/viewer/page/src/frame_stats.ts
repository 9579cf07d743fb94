// For measurements and tests, as attributes of the canvas: frames a second, the page's own work in a frame, and how many frames were
// drawn and how many skipped because nothing visible had changed.
const kWindow_ms = 1000;
const kHidden_ms = 2000; // between two frames of a page that is hidden
const kMostSkipped = 0.3;

export class FrameStats {
  private since_ms = performance.now();
  private frames = 0;
  private drawn = 0;
  private drawn_before = 0;
  private work_ms = 0;
  private worst_ms = 0;
  private all = 0;

  constructor(private readonly data: DOMStringMap) {}

  // After the work of a frame. Once a second while pictures are drawn all the time: how many frames a second there are.
  count(begin_ms: number, drew: boolean): number | null {
    const end_ms = performance.now();
    ++this.frames;
    ++this.all;
    if (drew) ++this.drawn;
    this.work_ms += end_ms - begin_ms;
    this.worst_ms = Math.max(this.worst_ms, end_ms - begin_ms);
    const span_ms = end_ms - this.since_ms;
    if (span_ms < kWindow_ms) return null;
    const frames_per_s = (this.frames * 1000) / span_ms;
    const busy = this.drawn - this.drawn_before > (1 - kMostSkipped) * this.frames;
    this.data.framesPerS = frames_per_s.toFixed(1);
    this.data.workMs = (this.work_ms / this.frames).toFixed(3);
    this.data.worstMs = this.worst_ms.toFixed(2);
    this.data.drawn = String(this.drawn);
    this.data.skipped = String(this.all - this.drawn);
    Object.assign(this, { since_ms: end_ms, frames: 0, work_ms: 0, worst_ms: 0, drawn_before: this.drawn });
    return busy && span_ms < kHidden_ms ? frames_per_s : null;
  }
}
