import { defaultClientConditions, defineConfig } from 'vite';

// `npm run dev` serves the page with hot reload; everything that changes comes from `npm run mock`.
const mock = 'http://127.0.0.1:8099';

// `--mode site` builds static files for any host, with the device in the page (src/in_page).
export default defineConfig(({ mode }) => ({
  base: './',
  resolve: { conditions: mode === 'site' ? ['site', ...defaultClientConditions] : [...defaultClientConditions] },
  worker: { format: 'es' },
  build: { target: 'es2022', emptyOutDir: true, chunkSizeWarningLimit: 1000 },
  server: { proxy: { '/live': { target: mock, ws: true }, '/scene.thim': mock, '/scenes.json': mock } },
}));
