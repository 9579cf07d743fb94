// Debian's Chromium without a window, with a software renderer; $CHROMIUM names another one. The shell draws no interface of its own: a page
// takes a third less of the processor than with `chromium --headless`.
import { type Browser, type Page, chromium } from 'playwright-core';

export function launch(): Promise<Browser> {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium-headless-shell',
    args: [
      '--no-sandbox',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--disable-gpu-compositing',
      '--disable-dev-shm-usage',
    ],
  });
}

// The number at the start of an element's text.
export async function number_in(page: Page, testid: string): Promise<number> {
  return Number.parseFloat((await page.getByTestId(testid).textContent()) ?? '');
}

export async function until(what: string, holds: () => Promise<boolean> | boolean, timeout_ms = 30_000): Promise<void> {
  const end = Date.now() + timeout_ms;
  while (!(await holds())) {
    if (Date.now() > end) throw new Error(`waited ${timeout_ms} ms for ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

// Where and how many pixels of the view are near a colour. The picture is decoded by the page itself.
export async function pixels_near(page: Page, rgb: [number, number, number], tolerance = 24): Promise<number> {
  const png = (await page.getByTestId('view').screenshot()).toString('base64');
  return page.evaluate(
    async ([data, wanted, limit]) => {
      const bitmap = new Image();
      bitmap.src = `data:image/png;base64,${data}`;
      await bitmap.decode();
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      const context = canvas.getContext('2d') as OffscreenCanvasRenderingContext2D;
      context.drawImage(bitmap, 0, 0);
      const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
      let count = 0;
      for (let i = 0; i < pixels.length; i += 4) {
        const off = Math.max(Math.abs(pixels[i] - wanted[0]), Math.abs(pixels[i + 1] - wanted[1]), Math.abs(pixels[i + 2] - wanted[2]));
        if (off <= limit) ++count;
      }
      return count;
    },
    [png, rgb, tolerance] as const,
  );
}
