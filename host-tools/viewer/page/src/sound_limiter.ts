// Keeps the sound below a level: no sample is larger than kLimit, 12 dB below what the loudspeaker can do.
export const kLimit = 0.25;
const kRelease_s = 0.15;

export class Limiter {
  private readonly forget: number;
  private envelope = 0;

  constructor(rate_Hz: number) {
    this.forget = Math.exp(-1 / (kRelease_s * rate_Hz));
  }

  take(sample: number): number {
    this.envelope = Math.max(Math.abs(sample), this.envelope * this.forget);
    return this.envelope > kLimit ? (sample * kLimit) / this.envelope : sample;
  }
}
