// One file: script, style and core (base64 of gzip) in the page, which may load nothing from anywhere.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { gzipSync } from "node:zlib";
import { parse } from "smol-toml";
import { defineConfig, type Plugin } from "vite";
import { asked, core } from "./src/asked";

const built = process.env.NONIUS_WASM ?? "";

/** `import texts from "….toml"`: the texts of the report and of this page are the same kind of file. */
const toml: Plugin = {
  name: "toml",
  transform: (code, id) =>
    id.endsWith(".toml") && !id.startsWith("\0") ? `export default ${JSON.stringify(parse(code))}` : null,
};

/** The core's own answer, as `import list from "core:controllers list"`: what never changes is asked when the page is built. */
const answers: Plugin = {
  name: "answers",
  resolveId: (id) => (id.startsWith("core:") ? "\0" + id : null),
  load(id) {
    if (!id.startsWith("\0core:")) return null;
    const words = id.slice("\0core:".length).split(" ").filter(Boolean);
    const answer = asked(core(new WebAssembly.Module(readFileSync(built))), { words, files: [] });
    if (answer.status !== 0) throw new Error(answer.err);
    return `export default ${JSON.stringify(answer)}`;
  },
};

/** Licences of everything in the page, packed: those of the core (packaging/licences) and of the scripts. */
const licences: Plugin = {
  name: "licences",
  resolveId: (id) => (id === "licences:" ? "\0" + id : null),
  load(id) {
    if (id !== "\0licences:") return null;
    const of = (name: string) => `${name}\n\n${readFileSync(resolve("node_modules", name, "LICENSE"), "utf8")}`;
    const scripts = ["preact", "@preact/signals", "@preact/signals-core", "fflate"].map(of);
    const all = [readFileSync(resolve("../../target/package/LICENCES.txt"), "utf8"), ...scripts].join(`\n${"-".repeat(78)}\n`);
    return `export default ${JSON.stringify(gzipSync(all, { level: 9 }).toString("base64"))}`;
  },
};

const single: Plugin = {
  name: "single",
  enforce: "post",
  generateBundle(_, bundle) {
    const page = bundle["index.html"];
    if (page?.type !== "asset") return;
    let html = String(page.source);
    const scripts: string[] = [];
    let start = "";
    for (const [name, part] of Object.entries(bundle)) {
      if (name === "index.html") continue;
      if (part.type === "chunk" && part.name === "start") {
        start = `(() => {${part.code.replaceAll("</script", "<\\/script")}})();`;
      } else if (part.type === "chunk") {
        html = html.replace(new RegExp(`\\s*<script[^>]*${name}[^>]*></script>`), "");
        scripts.push(part.code.replaceAll("</script", "<\\/script"));
      } else {
        html = html.replace(new RegExp(`<link[^>]*${name}[^>]*>`), () => `<style>${part.source}</style>`);
      }
      delete bundle[name];
    }
    const hashes = [start, ...scripts].map((code) => `'sha256-${createHash("sha256").update(code).digest("base64")}'`);
    const policy = [
      "default-src 'none'",
      `script-src 'wasm-unsafe-eval' ${hashes.join(" ")}`,
      "style-src 'unsafe-inline'", // the report in its frame inherits this policy, too
      "img-src data: blob:",
      "worker-src blob:",
      "base-uri 'none'",
      "form-action 'none'",
    ].join("; ");
    const packed = gzipSync(readFileSync(built), { level: 9 }).toString("base64");
    const parts = scripts.map((code) => `<script type="module">${code}</script>`).join("");
    html = html.replace("<!-- policy -->", () => `<meta http-equiv="Content-Security-Policy" content="${policy}">`);
    html = html.replace("<!-- start -->", () => `<script>${start}</script>`);
    html = html.replace("<!-- core -->", () => `<script type="application/gzip" id="core">${packed}</script>${parts}`);
    page.source = html;
  },
};

export default defineConfig({
  plugins: [toml, answers, licences, single],
  build: { rollupOptions: { input: { index: "index.html", start: "src/start.ts" } }, target: "es2022", assetsInlineLimit: 1 << 24, cssCodeSplit: false, modulePreload: false },
  worker: { format: "iife" },
});
