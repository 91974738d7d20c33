// Asks the core: a command with files by name, as on a command line.
import type { Told } from "./problems";

export interface Question {
  words: string[];
  files: [string, Uint8Array][];
}

export interface Answer {
  /** 0 done and within limits, 1 the answer is no, 2 could not do it. */
  status: number;
  out: string;
  err: string;
  told: Told;
  /** All files that are there afterwards. */
  files: [string, Uint8Array][];
}

const worker = window.coreThread;
const waiting = new Map<number, { done: (answer: Answer) => void; failed: (fault: Error) => void }>();
let last = 0;

worker.onmessage = ({ data }: MessageEvent) => {
  const { done, failed } = waiting.get(data.id)!;
  waiting.delete(data.id);
  if (data.fault) failed(new Error(data.fault));
  else done(data.answer);
};

function post(message: object): Promise<Answer> {
  const id = ++last;
  return new Promise((done, failed) => {
    waiting.set(id, { done, failed });
    worker.postMessage({ id, ...message });
  });
}

/** As soon as the core is unpacked. */
export const ready = post({ base64: document.getElementById("core")!.textContent });

/** Runs a command on these files. */
export async function run(words: string[], files: Iterable<[string, Uint8Array]> = []): Promise<Answer> {
  await ready;
  return post({ question: { words, files: [...files] } satisfies Question });
}
