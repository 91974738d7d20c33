// The visit is kept in this browser, where it can.
import { signal } from "@preact/signals";

export interface Kept {
  files: ReadonlyMap<string, Uint8Array>;
  job: string;
  after: string;
}

/** Whether this browser keeps the visit. */
export const keeps = signal(true);

function store(mode: IDBTransactionMode): Promise<IDBObjectStore> {
  return new Promise((done, failed) => {
    const asked = indexedDB.open("nonius", 1);
    asked.onupgradeneeded = () => asked.result.createObjectStore("visit");
    asked.onerror = () => failed(asked.error);
    asked.onsuccess = () => done(asked.result.transaction("visit", mode).objectStore("visit"));
  });
}

function ended<T>(asked: IDBRequest<T>): Promise<T> {
  return new Promise((done, failed) => {
    asked.onerror = () => failed(asked.error);
    asked.onsuccess = () => done(asked.result);
  });
}

export async function remember(visit: Kept) {
  try {
    await ended((await store("readwrite")).put(visit, "now"));
  } catch {
    keeps.value = false;
  }
}

export async function kept(): Promise<Kept | undefined> {
  try {
    return await ended((await store("readonly")).get("now"));
  } catch {
    keeps.value = false;
    return undefined;
  }
}
