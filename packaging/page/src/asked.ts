// A question to the core and its answer over the memory that both see: parts with their lengths before them
// (crates/nonius-wasm).
import type { Answer, Question } from "./core";

type Said = Pick<Answer, "status" | "err" | "told">;

interface Core {
  memory: WebAssembly.Memory;
  room(length: number): number;
  run(start: number, length: number): number;
  forget(start: number, length: number): void;
}

const text = new TextDecoder();
const bytes = new TextEncoder();

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

export function core(of: WebAssembly.Module): Core {
  return new WebAssembly.Instance(of, imports(of)).exports as unknown as Core;
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

function parted(all: Uint8Array): Uint8Array[] {
  const view = new DataView(all.buffer, all.byteOffset, all.length);
  const found: Uint8Array[] = [];
  for (let at = 0; at + 4 <= all.length; ) {
    const length = view.getUint32(at, true);
    found.push(all.slice(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return found;
}

export function asked(of: Core, question: Question): Answer {
  const all = joined([
    bytes.encode(question.words.join("\0")),
    ...question.files.flatMap(([name, content]) => [bytes.encode(name), content]),
  ]);
  const start = of.room(all.length);
  new Uint8Array(of.memory.buffer, start, all.length).set(all);
  const end = of.run(start, all.length);
  const length = new DataView(of.memory.buffer, end, 4).getUint32(0, true);
  const [told, out, ...files] = parted(new Uint8Array(of.memory.buffer, end + 4, length));
  of.forget(end, length + 4);
  const named: [string, Uint8Array][] = [];
  for (let n = 0; n + 1 < files.length; n += 2) named.push([text.decode(files[n]), files[n + 1]!]);
  return { ...(JSON.parse(text.decode(told)) as Said), out: text.decode(out), files: named };
}
