// Recordings as a user makes them on a page, and what they are worth: replayed at the desk and in the page with the same log.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';

import type { Page } from 'playwright-core';

import { Compiler } from '../../src/in_page/compiler';
import type { Replayed } from '../../src/transport';
import { kModule, kThimble } from './modules';

const kTimeout_ms = 60_000;

export async function shows(page: Page, id: string, part: string): Promise<void> {
  const has = ([id, it]: string[]) => document.querySelector(`[data-testid=${id}]`)?.textContent?.includes(it);
  await page.waitForFunction(has, [id, part], { timeout: kTimeout_ms }).catch(async () => {
    const seen = await Promise.all([id, 'mode', 'link', 'scene', 'messages'].map((it) => page.getByTestId(it).textContent()));
    throw new Error(`"${part}" is not shown: ${seen.join('; ')}`);
  });
}
export const feels = (page: Page): Promise<unknown> =>
  page.waitForFunction(() => Number.parseFloat(document.querySelector('[data-testid=force]')?.textContent ?? '') > 0.3, null, {
    timeout: kTimeout_ms,
  });

export async function save(page: Page, button: string, file: string): Promise<string> {
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByTestId(button).click()]);
  await download.saveAs(file);
  return file;
}

// The desk's log of it. Every force up to its end, or the first gap, is the device's to the bit, for `thimble replay` and for the page's module.
export function assert_exact(file: string): { log: Buffer; said: Replayed } {
  execFileSync(kThimble, ['replay', file, '--log', `${file}.csv`], { stdio: 'ignore' });
  const log = readFileSync(`${file}.csv`);
  const parts: Uint8Array[] = [];
  const said = new Compiler(kModule).replay(file, readFileSync(file), (part) => void parts.push(part));
  assert.ok(log.length > 1000 && log.equals(Buffer.concat(parts)), `${file}: another log than that of the desk`);
  assert.ok(said.exact && said.exact_to > said.first_tick, JSON.stringify(said));
  return { log, said };
}
