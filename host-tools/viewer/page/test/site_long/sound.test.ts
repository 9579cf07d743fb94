// What is heard: the forces of the device in Node.js, through the site's own audio worklet in Chromium.
import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import type { Browser, Page } from 'playwright-core';

import { kLimit } from '../../src/sound_limiter';
import { launch } from '../browser/browser';
import { amplitude } from '../tone';
import { Bench } from '../site/bench';
import { kSite } from '../site/modules';
import { serve_site } from '../site/serve';

const kTick_Hz = 4000;
const kSample_Hz = 48_000;
const kWorklet = readdirSync(join(kSite, 'assets')).find((name) => name.startsWith('sound_worklet'));
const kSpeed_m_s = 0.25;
const kScene = JSON.stringify({
  thimble_scene: 1,
  name: 'ridges',
  objects: [
    {
      name: 'ridges',
      shape: { box: { size_m: [0.12, 0.06, 0.02] } },
      pose: { position_m: [0, 0, -0.04] },
      material: {
        stiffness_N_m: 800,
        damping_N_s_m: 1,
        texture: { kind: 'height', pattern: 'ridges', tile_m: [kSpeed_m_s / 250, kSpeed_m_s / 250], height_m: 0.00003 },
      },
    },
  ],
});

let browser: Browser;
let page: Page;
let site: Awaited<ReturnType<typeof serve_site>>;
before(async () => {
  site = await serve_site();
  browser = await launch();
  page = await browser.newPage();
  await page.addInitScript('globalThis.__name = (it) => it'); // of what tsx makes of a function
  await page.route('**/empty', (route) => route.fulfill({ contentType: 'text/html', body: '' }));
  await page.goto(`${site.address}empty`); // the site without its device
});
after(async () => {
  await browser.close();
  site.server.close();
});

// The ticks come as the device's worker sends them: some milliseconds at a time.
async function render(forces_N: number[], arms = 1): Promise<number[]> {
  return page.evaluate(
    async ({ worklet, forces_N, arms, tick_Hz, sample_Hz }) => {
      const part_s = 128 / sample_Hz; // suspend() has no finer steps
      const parts = Math.floor(forces_N.length / (3 * arms * tick_Hz * part_s));
      const context = new OfflineAudioContext(1, parts * 128, sample_Hz);
      await context.audioWorklet.addModule(worklet);
      const node = new AudioWorkletNode(context, 'force-sound', { numberOfInputs: 0, outputChannelCount: [1] });
      node.connect(context.destination);
      let sent = 0;
      const kEvery = 8;
      for (let part = 0; part < parts; part += kEvery)
        void context.suspend(part * part_s).then(async () => {
          const end = 3 * arms * Math.round((part + kEvery) * part_s * tick_Hz);
          node.port.postMessage({ forces_N: new Float32Array(forces_N.slice(sent, end)), arms, rate_Hz: tick_Hz });
          sent = end;
          await new Promise((later) => setTimeout(later));
          await context.resume();
        });
      return [...(await context.startRendering()).getChannelData(0)];
    },
    { worklet: `${site.address}assets/${kWorklet}`, forces_N, arms, tick_Hz: kTick_Hz, sample_Hz: kSample_Hz },
  );
}

const largest = (samples: number[]): number => samples.reduce((most, sample) => Math.max(most, Math.abs(sample)), 0);

test('a texture that a hand strokes at 250 ridges a second is heard at 250 Hz; free space is silent', { timeout: 120_000 }, async () => {
  const bench = new Bench();
  bench.own.set('ridges', kScene);
  bench.post({ type: 'pick', scene: 'ridges' });
  bench.until('armed', () => bench.newest?.mode === 'armed');
  bench.run(1);
  bench.listen();
  bench.go(0.4, [0, 0, 0], [-0.05, 0, -0.02]);
  const touched_s = bench.forces_N.findIndex((force) => force !== 0) / 3 / kTick_Hz;
  assert.ok(touched_s < 0, 'the way to the surface is free space');
  bench.go(0.3, [-0.05, 0, -0.02], [-0.05, 0, -0.034]);
  bench.run(0.5);
  const stroke_s = bench.forces_N.length / 3 / kTick_Hz;
  bench.go(0.1 / kSpeed_m_s, [-0.05, 0, -0.034], [0.05, 0, -0.034]);
  const left_s = bench.forces_N.length / 3 / kTick_Hz;
  bench.go(0.2, [0.05, 0, -0.034], [0.05, 0, -0.01]);
  bench.run(0.5);

  const heard = await render(bench.forces_N);
  const part = (from_s: number, to_s: number) => heard.slice(from_s * kSample_Hz, to_s * kSample_Hz);
  assert.equal(largest(part(0, 0.4)), 0);
  assert.ok(largest(part(stroke_s - 0.2, stroke_s)) < 0.012, 'a steady push'); // what its encoders step by
  const stroke = part(stroke_s + 0.12, left_s); // the hand has its speed, and the sound comes some 40 ms late
  const loudness = Array.from({ length: 200 }, (_, i) => amplitude(stroke, kSample_Hz, 5 * (i + 1)));
  const peak_Hz = 5 * (loudness.indexOf(Math.max(...loudness)) + 1);
  assert.ok(Math.abs(peak_Hz - 250) <= 5, `${peak_Hz} Hz`); // the window of 0.28 s resolves 4 Hz
  assert.ok(Math.max(...loudness) > 0.02, `${Math.max(...loudness)}`);
  assert.ok(largest(heard) <= kLimit);
  assert.equal(largest(part(left_s + 0.45, left_s + 0.6)), 0, 'after the contact');
});

test('the button plays the device in the page while it is on', { timeout: 120_000 }, async () => {
  const live = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const errors: string[] = [];
  live.on('pageerror', (error) => errors.push(String(error)));
  await live.goto(site.address);
  await live.waitForFunction(() => document.querySelector('[data-testid=mode]')?.textContent === 'armed', null, { timeout: 60_000 });
  const button = live.getByTestId('sound');
  assert.equal(await button.getAttribute('aria-pressed'), 'false');
  await button.click();
  const peak = (wanted: string) =>
    live.waitForFunction(`(() => { const peak = document.getElementById('sound').dataset.peak; return ${wanted}; })()`, null, {
      timeout: 20_000,
    });
  await peak('peak === "0.0000"'); // it reports, and nothing touches
  await live.getByTestId('view').focus();
  await live.keyboard.down('ArrowDown');
  await peak(`peak > 0 && peak <= ${kLimit}`);
  await live.keyboard.up('ArrowDown');
  await button.click();
  assert.equal(await button.getAttribute('aria-pressed'), 'false');
  await peak('peak === undefined');
  assert.deepEqual(errors, []);
  await live.close();
});
