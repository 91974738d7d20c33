// The visit is kept in this browser, where it can; of several windows by the one that was opened last.
import { signal } from "@preact/signals";

export interface Kept {
  files: ReadonlyMap<string, Uint8Array>;
  job: string;
  after: string;
  language?: string;
}

/** Whether this browser keeps the visit, or another window of it does. */
export const keeps = signal<"here" | "nowhere" | "elsewhere">("here");

const own = crypto.randomUUID();

async function store(mode: IDBTransactionMode): Promise<IDBObjectStore> {
  const asked = indexedDB.open("nonius", 1);
  asked.onupgradeneeded = () => asked.result.createObjectStore("visit");
  return (await ended(asked)).transaction("visit", mode).objectStore("visit");
}

function ended<T>(asked: IDBRequest<T>): Promise<T> {
  return new Promise((done, failed) => {
    asked.onerror = () => failed(asked.error);
    asked.onsuccess = () => done(asked.result);
  });
}

async function tried<T>(what: () => Promise<T>): Promise<T | undefined> {
  try {
    return await what();
  } catch {
    keeps.value = "nowhere";
    return undefined;
  }
}

/** From now on this window keeps its visit; others notice it. */
export const claim = () => tried(async () => ended((await store("readwrite")).put(own, "window")));

export const remember = (visit: Kept) =>
  tried(async () => {
    const all = await store("readwrite");
    if ((await ended(all.get("window"))) === own) await ended(all.put(visit, "now"));
    else keeps.value = "elsewhere";
  });

/** Whether another window was opened meanwhile: asked when a person comes back to this one. */
export const look = () =>
  tried(async () => {
    if ((await ended((await store("readonly")).get("window"))) !== own) keeps.value = "elsewhere";
  });

export const kept = () => tried(async () => ended<Kept | undefined>((await store("readonly")).get("now")));
