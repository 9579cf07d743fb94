// The amplitude of a tone in samples, by their Fourier integral with a Hann window.
export function amplitude(samples: readonly number[], rate_Hz: number, tone_Hz: number): number {
  let [real, imaginary] = [0, 0];
  samples.forEach((sample, i) => {
    const windowed = sample * (1 - Math.cos((2 * Math.PI * (i + 0.5)) / samples.length));
    real += windowed * Math.cos((2 * Math.PI * tone_Hz * i) / rate_Hz);
    imaginary += windowed * Math.sin((2 * Math.PI * tone_Hz * i) / rate_Hz);
  });
  return (2 * Math.hypot(real, imaginary)) / samples.length;
}
