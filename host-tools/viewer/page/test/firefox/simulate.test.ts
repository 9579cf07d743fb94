// The site's controller in Debian's Firefox: its logs are those of `thimble simulate`, byte for byte.
import { test } from 'node:test';

import { launch } from 'puppeteer-core';

import { same_logs } from '../site/in_browser';
import { all_runs } from '../site/runs';

test('in Firefox', async () => {
  const browser = await launch({
    browser: 'firefox',
    executablePath: process.env.FIREFOX ?? '/usr/bin/firefox-esr',
    headless: true,
    protocolTimeout: 600_000,
  });
  try {
    await same_logs(await browser.newPage(), all_runs());
  } finally {
    await browser.close();
  }
});
