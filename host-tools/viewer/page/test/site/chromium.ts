// The site and a browser for all tests of a file.
import { after, before } from 'node:test';

import type { Browser } from 'playwright-core';

import { launch } from '../browser/browser';
import { serve_site } from './serve';

export interface SiteInChromium {
  browser: Browser;
  address: string;
}

// What it returns is there once the tests run.
export function site_in_chromium(): SiteInChromium {
  const it = {} as SiteInChromium;
  let site: Awaited<ReturnType<typeof serve_site>>;
  before(async () => {
    site = await serve_site();
    Object.assign(it, { browser: await launch(), address: site.address });
  });
  after(async () => {
    await it.browser.close();
    site.server.close();
  });
  return it;
}
