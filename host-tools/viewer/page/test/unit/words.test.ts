// The page's words: every limit of the device has one, and remedies name what is on the page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { kTop } from '../../mock/server';
import { kLimits, limits_text } from '../../src/limit_words';
import { on_this_page } from '../../src/remedies';

const read = (file: string): string => readFileSync(join(kTop, file), 'utf8');

test('every limit of the device has plain words', () => {
  const [, flags] = /FLAG_SET\(Limiter,(.*?)END_ENUM/s.exec(read('firmware/link/messages.def'))!;
  const names = [...flags.matchAll(/^VALUE\(\w+, \d+, "(\w+)"/gm)].map(([, name]) => name);
  assert.ok(names.length >= 7);
  assert.deepEqual(Object.keys(kLimits), names);
  assert.equal(limits_text(['clamp', 'slew', 'new_one']), 'largest force, fastest change, new_one');
  assert.equal(limits_text([]), 'nothing');
});

test('remedies name the button or the panel where this page has one', () => {
  assert.equal(on_this_page('home the arm (`thimble home`)'), 'home the arm (the button "Home")');
  assert.equal(on_this_page('see `thimble info`'), 'see `thimble info`');
  const page = read('host-tools/viewer/page/index.html').replace(/\s+/g, ' ');
  const remedies = ['firmware/core/conditions.def', 'host-tools/client/remedies.cpp', 'host-tools/client/service_client.cpp']
    .map(read)
    .join();
  const commands = new Set([...remedies.matchAll(/`thimble (\w+ ?\w*)`/g)].map(([whole]) => whole));
  const mapped = [...commands].map(on_this_page).filter((it) => !it.startsWith('`'));
  assert.ok(mapped.length >= 5, `${mapped}`);
  for (const it of mapped) {
    const [, name] = /"(.+)"/.exec(it)!;
    assert.match(page, new RegExp(`<(button|h2|summary)[^>]*> ?${name} ?(<small>Esc</small> )?</`), it);
  }
});
