// Recordings: made of the device, saved, and replayed where the page can.
import type { Alerts } from './alerts';
import { download } from './curve_table';
import { element, set_text } from './dom';
import type { PageMessage, RecordingState } from './protocol';
import { end_words, ended_by_itself, minutes, recorded_words, recording_file_name, replayed_words } from './recording_words';
import type { Replayer, Transport } from './transport';

const kBegin_ms = 5000; // one that is refused never begins
const kSilent_ms = 2000; // a device that records says so twice a second

interface RecordingFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
}

export class Recordings {
  private readonly record = element<HTMLButtonElement>('record');
  private readonly save = element<HTMLButtonElement>('record-save');
  private readonly replay_last = element<HTMLButtonElement>('replay-last');
  private readonly save_log = element<HTMLButtonElement>('replay-log');
  private on = false;
  private pressed_ms = -Infinity; // when one was asked for here
  private begun = false; // here
  private asked = false; // to end it
  private last: RecordingFile | null = null;
  private replayed: RecordingFile | null = null;
  private recorded_scene = 'scene';
  private silence: ReturnType<typeof setTimeout> | undefined;
  scene = 'scene'; // that runs

  constructor(
    private readonly transport: Transport,
    send: (message: PageMessage) => boolean,
    private readonly alerts: Alerts,
  ) {
    this.record.addEventListener('click', () => {
      this.asked = this.on;
      this.pressed_ms = this.on ? -Infinity : performance.now();
      send({ type: 'record', on: !this.on });
    });
    this.save.addEventListener('click', () => this.last && download(new Blob([this.last.bytes]), this.last.name));
    const { replay } = transport;
    if (replay) this.offer_replay(replay);
  }

  allow(may: boolean): void {
    this.record.disabled = !may;
  }

  take(state: RecordingState): void {
    if (state.on && !this.on) {
      this.asked = false;
      this.begun = performance.now() - this.pressed_ms < kBegin_ms;
      this.recorded_scene = this.scene;
      set_text(element('record-said'), 'It records. Homing and arming are part of it; press Record again to end it.');
    }
    this.show(state.on ? state.seconds : null);
    if (state.on) return;
    this.tell_end(state);
    void this.fetch();
  }

  private tell_end(state: RecordingState): void {
    set_text(element('record-said'), recorded_words(state, this.asked));
    const is_missed = this.begun && !this.asked;
    if (!is_missed && !ended_by_itself(state, this.asked)) return;
    const cause = `the recording has ended after ${minutes(state.seconds)}: ${end_words(state, this.asked)}`;
    this.alerts.say({ level: 'error', name: 'recording-ended', cause, remedy: 'save what was recorded up to there' });
  }

  // seconds: null: nothing is recorded.
  private show(seconds: number | null): void {
    this.on = seconds !== null;
    this.record.setAttribute('aria-pressed', String(this.on));
    set_text(element('recording-mark'), seconds === null ? '' : `Recording ${minutes(seconds)}`);
    clearTimeout(this.silence);
    if (this.on) this.silence = setTimeout(() => this.lose(), kSilent_ms);
  }
  // Whoever records does not say so any more. It may go on, and is heard of again then.
  private lose(): void {
    this.show(null);
    set_text(element('record-said'), 'Nothing is heard of the recording any more. It is lost unless the link comes back.');
  }

  private async fetch(): Promise<void> {
    try {
      const bytes = await this.transport.recording();
      this.last = { name: recording_file_name(this.recorded_scene, new Date()), bytes };
      this.save.disabled = false;
      this.replay_last.disabled = false;
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      this.alerts.say({ level: 'error', name: 'no-recording', cause, remedy: 'record it again' });
    }
  }

  private offer_replay(replay: Replayer): void {
    for (const id of ['replay', 'replay-said']) element(id).hidden = false;
    const input = element<HTMLInputElement>('replay-file');
    element('replay-choose').addEventListener('click', () => input.click());
    input.addEventListener('change', () => {
      for (const file of input.files ?? []) void this.open(replay, file);
      input.value = '';
    });
    this.replay_last.addEventListener('click', () => this.last && void this.play(replay, this.last));
    this.save_log.addEventListener('click', () => this.replayed && void this.write_log(replay, this.replayed));
    addEventListener('dragover', (event) => event.dataTransfer?.types.includes('Files') && event.preventDefault());
    addEventListener('drop', (event) => this.drop(replay, event), { capture: true });
  }

  // Other files are for others.
  private drop(replay: Replayer, event: DragEvent): void {
    const file = [...(event.dataTransfer?.files ?? [])].find(({ name }) => name.toLowerCase().endsWith('.rec'));
    if (file === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    void this.open(replay, file);
  }

  private async open(replay: Replayer, file: File): Promise<void> {
    await this.play(replay, { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) });
  }

  private async play(replay: Replayer, recording: RecordingFile): Promise<void> {
    const said = element('replay-said');
    set_text(said, `Replaying ${recording.name}.`);
    this.save_log.disabled = true;
    const { replayed } = await replay(recording.name, recording.bytes, false);
    set_text(said, replayed_words(replayed));
    if (replayed.error) return this.alerts.say({ level: 'error', ...replayed.error });
    this.replayed = recording;
    this.save_log.disabled = false;
  }

  private async write_log(replay: Replayer, { name, bytes }: RecordingFile): Promise<void> {
    const { log } = await replay(name, bytes, true);
    if (log !== null) download(log, name.replace(/\.rec$/i, '.csv'));
  }
}
