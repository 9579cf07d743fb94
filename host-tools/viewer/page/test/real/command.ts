// The built commands, as processes: `thimble view`, and `thimble-sim` where the controller is a process of its own. $THIMBLE names the
// former, the latter lies beside it.
import { type ChildProcess, execFile, execFileSync, spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

export const kTop = join(dirname(fileURLToPath(import.meta.url)), '../../../../..');
const kThimble = process.env.THIMBLE ?? join(kTop, 'build/release/bin/thimble');

export const scene_file = (name: string, folder = name): string => join(kTop, 'scenes', folder, `${name}.scene.json`);

export class Command {
  private readonly errors: Buffer[] = [];

  private constructor(private readonly process: ChildProcess) {
    process.stderr?.on('data', (data: Buffer) => this.errors.push(data));
  }

  get exit_code(): number | null {
    return this.process.exitCode;
  }

  // Resolves with its first lines, up to the one that `last` takes.
  static async start(
    program: 'thimble' | 'thimble-sim',
    words: string[],
    last: (line: string) => boolean,
    from: 'stdout' | 'stderr' = 'stdout',
  ): Promise<[Command, string[]]> {
    const file = program === 'thimble' ? kThimble : join(dirname(kThimble), program);
    if (!existsSync(file)) throw new Error(`there is no ${file}: build it, or name thimble in THIMBLE`);
    const command = new Command(spawn(file, words, { stdio: ['ignore', 'pipe', 'pipe'] }));
    const lines: string[] = [];
    for await (const line of createInterface({ input: command.process[from]! })) {
      lines.push(line);
      if (last(line)) return [command, lines];
    }
    throw new Error(`${program} ${words.join(' ')} did not start: ${Buffer.concat(command.errors)}`);
  }

  async stop(signal: NodeJS.Signals = 'SIGTERM'): Promise<number | null> {
    if (this.process.exitCode === null && this.process.signalCode === null) {
      const gone = once(this.process, 'exit');
      this.process.kill(signal);
      await gone;
    }
    return this.process.exitCode;
  }
}

export interface View {
  url: string; // with the token
  command: Command;
}

// Resolves when it serves.
export async function view(...words: string[]): Promise<View> {
  const [command, [url]] = await Command.start('thimble', ['view', '--no-browser', ...words], () => true);
  return { url, command };
}

export interface Simulator {
  address: string;
  command: Command;
}

export async function simulator(port = 0): Promise<Simulator> {
  const [command, lines] = await Command.start('thimble-sim', ['--tcp', `${port}`, '--no-pty'], (line) => line === 'ready');
  const address = lines.find((line) => line.startsWith('tcp:'));
  if (address === undefined) throw new Error('thimble-sim has no TCP port');
  return { address, command };
}

export function thimble(...words: string[]): string {
  return execFileSync(kThimble, words, { encoding: 'utf8' });
}
// While this process has other things to do.
export const thimble_beside = (...words: string[]): Promise<unknown> => promisify(execFile)(kThimble, words);
