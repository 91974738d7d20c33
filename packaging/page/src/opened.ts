// Files that a person drops or chooses, and those that are saved.
import { unzipSync, zipSync } from "fflate";
import type { Files } from "./visit";
import { t } from "./words";

async function bytes(file: File): Promise<Uint8Array> {
  return new Uint8Array(await file.arrayBuffer());
}

async function within(entry: FileSystemEntry, into: Map<string, Uint8Array>): Promise<void> {
  const path = entry.fullPath.replace(/^\//, "");
  if (entry.isFile) {
    const file = await new Promise<File>((done, failed) => (entry as FileSystemFileEntry).file(done, failed));
    into.set(path, await bytes(file));
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return;
    for (const one of some) await within(one, into);
  }
}

/** What a zip holds; some programs write `\` between its folders. */
function unzipped(name: string, content: Uint8Array): [string, Uint8Array][] {
  try {
    return Object.entries(unzipSync(content)).map(([path, of]) => [path.replaceAll("\\", "/"), of]);
  } catch {
    throw new Error(t("broken_zip", { file: name }));
  }
}

function unpacked(all: Map<string, Uint8Array>): Files {
  const found = new Map<string, Uint8Array>();
  for (const [name, content] of all) {
    // Two visits have the same names inside.
    const folder = all.size > 1 ? `${name.replace(/\.zip$/i, "")}/` : "";
    const isOwn = (path: string) => !/(^|\/)(__MACOSX\/|\._|\.DS_Store$)|\/$/.test(path);
    const inside = /\.zip$/i.test(name) ? unzipped(name, content) : [];
    if (!inside.length && isOwn(name)) found.set(name, content);
    for (const [path, of] of inside.filter(([path]) => isOwn(path))) found.set(folder + path, of);
  }
  return found;
}

export async function dropped(data: DataTransfer): Promise<Files> {
  const entries = [...data.items].flatMap((item) => item.webkitGetAsEntry?.() ?? []);
  const loose = [...data.files];
  const found = new Map<string, Uint8Array>();
  for (const entry of entries) await within(entry, found);
  if (!entries.length) for (const file of loose) found.set(file.name, await bytes(file));
  return unpacked(found);
}

export async function chosen(list: FileList | null): Promise<Files> {
  const found = new Map<string, Uint8Array>();
  for (const file of list ?? []) found.set(file.webkitRelativePath || file.name, await bytes(file));
  return unpacked(found);
}

export function save(name: string, content: Uint8Array | string, type = "application/octet-stream") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content as BlobPart], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function zip(files: Iterable<[string, Uint8Array]>): Uint8Array {
  return zipSync(Object.fromEntries(files));
}
