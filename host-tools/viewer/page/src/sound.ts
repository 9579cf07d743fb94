// The sound of the forces while it is on: the way of the forces of all ticks from the device to the audio worklet.
import type { FromSound } from './sound_worklet';
import worklet from './sound_worklet.ts?worker&url';

export class Sound {
  private readonly context = new AudioContext({ latencyHint: 'interactive' });
  private closed = false;

  // report: some times a second.
  constructor(private readonly report: (report: FromSound) => void) {}

  // The port that takes the forces of all ticks (TickForces). Null: closed meanwhile. Throws where there is no sound.
  async open(): Promise<MessagePort | null> {
    await this.context.audioWorklet.addModule(worklet);
    if (this.closed) return null;
    const node = new AudioWorkletNode(this.context, 'force-sound', { numberOfInputs: 0, outputChannelCount: [1] });
    node.port.onmessage = ({ data }: MessageEvent<FromSound>) => this.report(data);
    node.connect(this.context.destination);
    const { port1, port2 } = new MessageChannel();
    node.port.postMessage({ from: port1 }, [port1]);
    return port2;
  }

  close(): void {
    this.closed = true;
    void this.context.close();
  }
}
