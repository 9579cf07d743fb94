// The site's controller in Chromium: its logs are those of `thimble simulate`, byte for byte.
import { test } from 'node:test';

import { launch } from '../browser/browser';
import { same_logs } from '../site/in_browser';
import { all_runs } from '../site/runs';

test('in Chromium', async () => {
  const browser = await launch();
  try {
    await same_logs(await browser.newPage(), all_runs());
  } finally {
    await browser.close();
  }
});
