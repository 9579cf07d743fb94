// The audio worklet of the sound: forces of ticks in, over its port; samples out.
import { Limiter } from './sound_limiter';
import { SoundQueue, type TickForces } from './sound_queue';
import { Resampler } from './sound_resampler';

// Of the scope of an audio worklet what is used here.
declare const sampleRate: number;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}
declare function registerProcessor(name: string, type: new () => AudioWorkletProcessor): void;

export type ToSound = TickForces | { from: MessagePort }; // from: where more of them come from
export interface FromSound {
  peak: number; // of the samples since the last one
  gaps: number;
}

const kGain_per_N = 0.4; // 0.1 N of texture is heard, 0.6 N reach the limit
const kReport_s = 0.25;

class ForceSound extends AudioWorkletProcessor {
  private readonly queue = new SoundQueue();
  private readonly resampler = new Resampler();
  private readonly limiter = new Limiter(sampleRate);
  private peak = 0;
  private unreported = 0;

  constructor() {
    super();
    this.port.onmessage = ({ data }: MessageEvent<ToSound>) => {
      if ('from' in data) data.from.onmessage = (event: MessageEvent<TickForces>) => this.queue.put(event.data);
      else this.queue.put(data);
    };
  }

  process(_inputs: Float32Array[][], outputs: Float32Array[][]): boolean {
    const [channel] = outputs[0];
    const step = this.queue.step(sampleRate);
    const next = (): number => this.queue.next();
    for (let i = 0; i < channel.length; ++i) {
      channel[i] = this.limiter.take(kGain_per_N * this.resampler.read(step, next));
      this.peak = Math.max(this.peak, Math.abs(channel[i]));
    }
    this.unreported += channel.length;
    if (this.unreported >= kReport_s * sampleRate) this.report();
    return true;
  }

  private report(): void {
    const report: FromSound = { peak: this.peak, gaps: this.queue.gaps };
    this.port.postMessage(report);
    this.peak = this.unreported = 0;
  }
}

registerProcessor('force-sound', ForceSound);
