// npm run mock -- [SCENE] [--port N] [--arms 2] [--device]: the page with a made-up tip, for working on the page.
import { parseArgs } from 'node:util';

import { Mock } from './server';

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    port: { type: 'string', default: '8099' },
    arms: { type: 'string', default: '1' },
    device: { type: 'boolean', default: false },
  },
});
const mock = new Mock({ scene: positionals[0], arms: Number(values.arms), simulated: !values.device });
await mock.start(Number(values.port));
console.log(mock.url);
