// npm run measure [-- SCENE]: frames a second, the page's own work in a frame, and the time from the server to the picture, with a mesh
// of 100 000 triangles where no scene is named; then how many frames are drawn of a hand at rest. In headless Chromium a processor draws the picture, so the frames a second are those of
// a machine without a GPU.
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { Mock } from '../../mock/server';
import { launch } from './browser';

const kRings = 160;
const kSeconds = 15;
const kStill_s = 5;

// A ball with waves, about 4 kRings^2 triangles.
function write_ball(file: string): void {
  const columns = 2 * kRings;
  const lines: string[] = [];
  for (let i = 0; i <= kRings; ++i)
    for (let j = 0; j < columns; ++j) {
      const [polar, turn] = [(Math.PI * i) / kRings, (2 * Math.PI * j) / columns];
      const r = 0.04 * (1 + 0.05 * Math.sin(9 * polar) * Math.sin(7 * turn));
      lines.push(`v ${r * Math.sin(polar) * Math.cos(turn)} ${r * Math.sin(polar) * Math.sin(turn)} ${r * Math.cos(polar)}`);
    }
  const vertex = (i: number, j: number) => i * columns + (j % columns) + 1;
  for (let i = 0; i < kRings; ++i)
    for (let j = 0; j < columns; ++j) lines.push(`f ${vertex(i, j)} ${vertex(i + 1, j)} ${vertex(i + 1, j + 1)} ${vertex(i, j + 1)}`);
  writeFileSync(file, lines.join('\n'));
}

function ball(): Mock {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-ball-'));
  try {
    write_ball(join(folder, 'ball.obj'));
    const material = { stiffness_N_m: 800, damping_N_s_m: 2 };
    const shape = { mesh: { file: 'ball.obj', crease_deg: 60 } };
    const scene = { thimble_scene: 1, name: 'ball', objects: [{ name: 'ball', shape, material }] };
    writeFileSync(join(folder, 'ball.scene.json'), JSON.stringify(scene));
    return new Mock({ scene: join(folder, 'ball.scene.json') });
  } finally {
    rmSync(folder, { recursive: true });
  }
}

const mock = process.argv[2] === undefined ? ball() : new Mock({ scene: process.argv[2] });
await mock.start();
mock.touch.command('home');
mock.touch.command('arm');

const browser = await launch();
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(mock.url);
await page.waitForSelector('canvas[data-triangles]');
await page.waitForTimeout(5000); // the picture has found its resolution
// As text: tsx adds calls to functions that the page does not have.
await page.evaluate(`{
  const canvas = document.querySelector('canvas#view');
  window.shown = [];
  let last = '';
  const look = () => {
    if (canvas.dataset.tick !== last) shown.push([Number((last = canvas.dataset.tick)), Date.now()]);
    requestAnimationFrame(look);
  };
  look();
}`);
const numbers = () => page.evaluate(() => ({ ...(document.querySelector('canvas#view') as HTMLCanvasElement).dataset }));
const frames_of = (before: DOMStringMap, after: DOMStringMap) =>
  `${Number(after.drawn) - Number(before.drawn)} drawn, ${Number(after.skipped) - Number(before.skipped)} skipped`;
const before = await numbers();
const rates: number[] = [];
const work: number[] = [];
const worst: number[] = [];
// It moves in every state, so every frame has something to draw.
const begin_ms = performance.now();
const moving = setInterval(() => {
  const turn = (performance.now() - begin_ms) / 1000;
  mock.touch.move_hand(0, [0.03 * Math.cos(turn), -0.02, 0.03 * Math.sin(turn)]);
}, 8);
for (let second = 0; second < kSeconds; ++second) {
  await page.waitForTimeout(1000);
  const data = await numbers();
  rates.push(Number(data.framesPerS));
  work.push(Number(data.workMs));
  worst.push(Number(data.worstMs));
}
clearInterval(moving);
const moved = await numbers();
await page.waitForTimeout(1000 * kStill_s);
const rested = await numbers();
const shown = await page.evaluate(() => (window as unknown as { shown: [number, number][] }).shown);
const delays = shown
  .flatMap(([tick, at_ms]) => (mock.sent_ms.has(tick) ? [at_ms - (mock.sent_ms.get(tick) as number)] : []))
  .sort((a, b) => a - b);
const median = (values: number[]) => [...values].sort((a, b) => a - b)[values.length >> 1];
const triangles = await page.getByTestId('view').getAttribute('data-triangles');
const renderer = await page.evaluate(() => {
  const gl = document.createElement('canvas').getContext('webgl2');
  return gl?.getParameter(gl.getExtension('WEBGL_debug_renderer_info')?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER) as string;
});
console.log(`renderer: ${renderer}`);
console.log(`triangles: ${triangles}`);
console.log(`frames a second: median ${median(rates)}, least ${Math.min(...rates)}`);
const mean = work.reduce((a, b) => a + b, 0) / work.length;
console.log(`the page's own work in a frame: mean ${mean.toFixed(2)} ms, worst ${Math.max(...worst)} ms`);
console.log(`frames of ${kSeconds} s while the hand moves: ${frames_of(before, moved)}`);
console.log(`frames of ${kStill_s} s while it rests: ${frames_of(moved, rested)}; work in a frame: mean ${rested.workMs} ms`);
console.log(`from the server to the frame that is drawn: median ${median(delays)} ms, 99 % ${delays[Math.floor(delays.length * 0.99)]} ms`);
await browser.close();
await mock.stop();
