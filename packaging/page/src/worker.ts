// The core, beside the page so that typing never waits: a question and its answer are parts with their lengths
// (crates/nonius-wasm).
import type { Answer, Question } from "./core";

interface Core {
  memory: WebAssembly.Memory;
  room(length: number): number;
  run(start: number, length: number): number;
  forget(start: number, length: number): void;
}

let module: WebAssembly.Module | undefined;
let core: Core | undefined;

const text = new TextDecoder();
const bytes = new TextEncoder();

async function unpacked(packed: Uint8Array<ArrayBuffer>): Promise<WebAssembly.Module> {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(stream).arrayBuffer());
}

/** What the core names and never calls: the reader of spreadsheets brings a way to random numbers along. */
function imports(of: WebAssembly.Module): WebAssembly.Imports {
  const all: WebAssembly.Imports = {};
  for (const { module, name } of WebAssembly.Module.imports(of)) {
    (all[module] ??= {})[name] = () => {
      throw new Error(`the core calls ${name}`);
    };
  }
  return all;
}

function joined(parts: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + 4 + part.length, 0));
  const view = new DataView(all.buffer);
  let at = 0;
  for (const part of parts) {
    view.setUint32(at, part.length, true);
    all.set(part, at + 4);
    at += 4 + part.length;
  }
  return all;
}

function parts(all: Uint8Array): Uint8Array[] {
  const view = new DataView(all.buffer, all.byteOffset, all.length);
  const found: Uint8Array[] = [];
  for (let at = 0; at + 4 <= all.length; ) {
    const length = view.getUint32(at, true);
    found.push(all.slice(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return found;
}

function answer(question: Question): Answer {
  if (!module) throw new Error("no core");
  core ??= new WebAssembly.Instance(module, imports(module)).exports as unknown as Core;
  const asked = joined([
    bytes.encode(String(question.words.length)),
    ...question.words.map((word) => bytes.encode(word)),
    ...question.files.flatMap(([name, content]) => [bytes.encode(name), content]),
  ]);
  try {
    const start = core.room(asked.length);
    new Uint8Array(core.memory.buffer, start, asked.length).set(asked);
    const end = core.run(start, asked.length);
    const length = new DataView(core.memory.buffer, end, 4).getUint32(0, true);
    const all = parts(new Uint8Array(core.memory.buffer, end + 4, length));
    core.forget(end, length + 4);
    const [status, out, err, ...files] = all;
    const named: [string, Uint8Array][] = [];
    for (let n = 0; n + 1 < files.length; n += 2) named.push([text.decode(files[n]), files[n + 1]!]);
    return { status: Number(text.decode(status)), out: text.decode(out), err: text.decode(err), files: named };
  } catch (fault) {
    core = undefined; // its memory cannot be trusted any more
    throw fault;
  }
}

self.onmessage = async ({ data }: MessageEvent) => {
  try {
    if (data.packed) {
      module = await unpacked(data.packed);
      self.postMessage({ id: data.id });
    } else {
      self.postMessage({ id: data.id, answer: answer(data.question) });
    }
  } catch (fault) {
    self.postMessage({ id: data.id, fault: String(fault) });
  }
};
