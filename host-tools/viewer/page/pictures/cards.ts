// npm run pictures:cards: the pictures of the gallery, scenes/*/NAME.webp, from those of docs/pictures (npm run pictures): the middle of the view, small.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { launch } from '../test/browser/browser';
import { kTop } from '../test/real/command';
import { kPictures } from './list';

const kView = { x: 118, y: 136, width: 440, height: 330 }; // in a picture, without what is written on the view
const kCard = { width: 192, height: 144, quality: 0.5 };

const browser = await launch();
const page = await browser.newPage();
let all = 0;
for (const { scene, folder } of kPictures) {
  const png = readFileSync(join(kTop, 'docs/pictures', `${scene}.png`)).toString('base64');
  const webp = await page.evaluate(
    async ({ png, view, card }) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const canvas = Object.assign(document.createElement('canvas'), { width: card.width, height: card.height });
      const context = canvas.getContext('2d') as CanvasRenderingContext2D;
      context.imageSmoothingQuality = 'high';
      context.drawImage(image, view.x, view.y, view.width, view.height, 0, 0, card.width, card.height);
      return canvas.toDataURL('image/webp', card.quality).split(',')[1];
    },
    { png, view: kView, card: kCard },
  );
  const bytes = Buffer.from(webp, 'base64');
  writeFileSync(join(kTop, 'scenes', folder, `${scene}.webp`), bytes);
  all += bytes.length;
}
await browser.close();
console.log(`${kPictures.length} pictures, ${(all / 1000).toFixed(1)} kB`);
