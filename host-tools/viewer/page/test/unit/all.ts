// All tests of this folder in one process: to start one for each file takes half a second of a processor.
import { readdirSync } from 'node:fs';

for (const file of readdirSync(new URL('.', import.meta.url)).sort()) if (file.endsWith('.test.ts')) await import(`./${file}`);
