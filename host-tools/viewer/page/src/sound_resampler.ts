// Samples at one rate to samples at a higher one, which may vary a little: band-limited interpolation with a windowed sinc (J. O. Smith,
// "Digital Audio Resampling"). What is above the pass band of the lower rate would be heard as tones that nobody feels.
const kZeros = 24; // of the sinc, on each side
const kSteps = 128; // of the table between two zeros
const kPass = 0.9; // of half the lower rate
const kWindow = 9; // Kaiser's beta: 90 dB

const bessel_0 = (x: number): number => {
  let [sum, term] = [1, 1];
  for (let k = 1; term > 1e-12 * sum; ++k) sum += term *= (x / (2 * k)) ** 2;
  return sum;
};

function make_table(): Float64Array {
  const table = new Float64Array(kZeros * kSteps + 2);
  for (let i = 0; i < kZeros * kSteps; ++i) {
    const x = i / kSteps;
    const angle = Math.PI * kPass * x;
    const window = bessel_0(kWindow * Math.sqrt(1 - (x / kZeros) ** 2)) / bessel_0(kWindow);
    table[i] = (x === 0 ? kPass : Math.sin(angle) / (Math.PI * x)) * window;
  }
  return table;
}

export class Resampler {
  private static readonly table = make_table();
  private readonly past = new Float64Array(2 * kZeros); // the newest input is the last one
  private phase = 0; // of the next output, in inputs since the middle of the past

  // next: the next input. step: inputs for each output, at most 1.
  read(step: number, next: () => number): number {
    for (this.phase += step; this.phase >= 1; --this.phase) {
      this.past.copyWithin(0, 1);
      this.past[this.past.length - 1] = next();
    }
    let sum = 0;
    for (let i = 0; i < kZeros; ++i) {
      sum += this.past[kZeros - 1 - i] * weight(Resampler.table, i + this.phase);
      sum += this.past[kZeros + i] * weight(Resampler.table, i + 1 - this.phase);
    }
    return sum;
  }
}

function weight(table: Float64Array, distance: number): number {
  const at = distance * kSteps;
  const index = Math.floor(at);
  return table[index] + (at - index) * (table[index + 1] - table[index]);
}
