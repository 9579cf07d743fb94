// Lighthouse on the page against the mock: npm run test:lighthouse. Its packages are apart from the page's (test/lighthouse).
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

import { Mock } from '../mock/server';

const kProgram = join(dirname(fileURLToPath(import.meta.url)), 'lighthouse/node_modules/.bin/lighthouse');
const kLeast = 95;
const kFlags = '--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-dev-shm-usage';

interface Report {
  categories: Record<string, { score: number; auditRefs: { id: string; weight: number }[] }>;
  audits: Record<string, { score: number | null; title: string }>;
}

for (const preset of ['desktop', 'phone'])
  test(`${preset}: accessibility and best practices are ${kLeast} or more`, async () => {
    assert.ok(existsSync(kProgram), 'npm run test:lighthouse installs it');
    const mock = new Mock();
    await mock.start();
    try {
      const words = [
        '--quiet',
        '--output=json',
        '--throttling-method=provided',
        '--only-categories=accessibility,best-practices',
        `--chrome-flags=${kFlags}`,
      ];
      if (preset === 'desktop') words.push('--preset=desktop');
      const env = { ...process.env, CHROME_PATH: process.env.CHROMIUM ?? '/usr/bin/chromium' };
      const { stdout } = await promisify(execFile)(kProgram, [mock.url, ...words], { env, maxBuffer: 1e8 });
      const { categories, audits } = JSON.parse(stdout) as Report;
      for (const [name, { score, auditRefs }] of Object.entries(categories)) {
        const lost = auditRefs.filter(({ id, weight }) => weight > 0 && audits[id].score !== null && audits[id].score < 1);
        console.log(`# ${preset}: ${name} ${Math.round(100 * score)}`);
        assert.ok(100 * score >= kLeast, `${name} ${100 * score}: ${lost.map(({ id }) => `${id} (${audits[id].title})`).join('; ')}`);
      }
    } finally {
      await mock.stop();
    }
  });
