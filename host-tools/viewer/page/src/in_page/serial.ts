// A board on a serial port of this computer, by Web Serial: bytes both ways, and the port again when it has been unplugged. The session speaks
// SLCAN (host-tools/in_page/page_links.cpp).

// Of the Web Serial API what is used here.
export interface Port {
  readonly readable: ReadableStream<Uint8Array> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  open(options: { baudRate: number; bufferSize: number }): Promise<void>;
  close(): Promise<void>;
}
interface Serial extends EventTarget {
  requestPort(): Promise<Port>;
}

const kBits_per_s = 3_000_000; // a USB port ignores it
const kBuffer_bytes = 65536;
const kRetry_ms = 300;

export const serial = (): Serial | null => ('serial' in navigator ? (navigator.serial as Serial) : null);

// Asks the user for a port. Rejects where the user chooses none.
export async function choose_port(): Promise<Port> {
  const all = serial();
  if (all === null) throw new Error('this browser has no Web Serial');
  return all.requestPort();
}

export class SerialBoard {
  private writer: WritableStreamDefaultWriter<Uint8Array> | null = null;
  private reader: ReadableStreamDefaultReader<Uint8Array> | null = null;
  private listening: Promise<void> = Promise.resolve();
  private closed = false;

  private constructor(
    private readonly port: Port,
    private readonly opened: (open: boolean) => void,
    private readonly heard: (bytes: Uint8Array) => void,
  ) {}

  // opened: each time that it opens and is lost. Rejects where it cannot be opened.
  static async begin(port: Port, opened: (open: boolean) => void, heard: (bytes: Uint8Array) => void): Promise<SerialBoard> {
    const board = new SerialBoard(port, opened, heard);
    await board.open();
    return board;
  }

  write(bytes: Uint8Array): void {
    this.writer?.write(bytes).catch(() => {}); // what is lost with the port
  }
  // Its port can be opened again, and nothing is heard of it any more.
  async close(): Promise<void> {
    this.closed = true;
    await this.reader?.cancel().catch(() => {});
    await this.listening;
  }

  private async open(): Promise<void> {
    await this.port.open({ baudRate: kBits_per_s, bufferSize: kBuffer_bytes });
    this.writer = this.port.writable?.getWriter() ?? null;
    this.opened(true);
    this.listening = this.listen();
  }
  // Until the port is lost; then again once it opens.
  private async listen(): Promise<void> {
    try {
      this.reader = this.port.readable?.getReader() ?? null;
      for (let part = await this.reader?.read(); part && !part.done; part = await this.reader?.read()) this.heard(part.value);
    } catch {
      // unplugged
    }
    this.reader?.releaseLock();
    this.writer?.releaseLock();
    this.reader = this.writer = null;
    await this.port.close().catch(() => {});
    if (this.closed) return;
    this.opened(false);
    void this.retry();
  }
  private async retry(): Promise<void> {
    while (!this.closed) {
      await new Promise((later) => setTimeout(later, kRetry_ms));
      if (this.closed) return;
      const is_open = await this.open().then(
        () => true,
        () => false,
      );
      if (is_open) return;
    }
  }
}
