// The site's controller in Node.js: its logs are those of `thimble simulate`, byte for byte.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Module } from '../../src/in_page/module';
import { kRate_Hz } from './in_browser';
import { kModule } from './modules';
import { all_runs } from './runs';

const runs = all_runs();

test('in Node.js', () => {
  const module = new Module(kModule);
  assert.ok(runs.length >= 24);
  for (const { name, image, path, log } of runs) {
    module.put(image, path);
    const here = module.given_text(module.call.simulate(image.length, 0, kRate_Hz));
    assert.ok(here === log, `${name}: another log: ${here.slice(0, 300)}`);
  }
});
