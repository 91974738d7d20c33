// The core, beside the page so that typing never waits.
import { asked, core } from "./asked";
import { unpacked } from "./unpacked";

let module: WebAssembly.Module | undefined;
let running: ReturnType<typeof core> | undefined;

/** Compiled while it is unpacked. */
function compiled(base64: string): Promise<WebAssembly.Module> {
  return WebAssembly.compileStreaming(new Response(unpacked(base64), { headers: { "Content-Type": "application/wasm" } }));
}

self.onmessage = async ({ data }: MessageEvent) => {
  try {
    if (data.base64) {
      module = await compiled(data.base64);
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
