// The core, beside the page so that typing never waits.
import { asked, core } from "./asked";

let module: WebAssembly.Module | undefined;
let running: ReturnType<typeof core> | undefined;

async function unpacked(base64: string): Promise<WebAssembly.Module> {
  const packed = atob(base64);
  const bytes = new Uint8Array(packed.length);
  for (let n = 0; n < packed.length; n++) bytes[n] = packed.charCodeAt(n);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compileStreaming(new Response(stream, { headers: { "Content-Type": "application/wasm" } }));
}

self.onmessage = async ({ data }: MessageEvent) => {
  try {
    if (data.base64) {
      module = await unpacked(data.base64);
      running = core(module);
      self.postMessage({ id: data.id });
      return;
    }
    running ??= core(module!);
    self.postMessage({ id: data.id, answer: asked(running, data.question) });
  } catch (fault) {
    running = undefined; // after a fault its memory cannot be trusted
    self.postMessage({ id: data.id, fault: String(fault) });
  }
};
