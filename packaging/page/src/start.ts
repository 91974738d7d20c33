// The thread of the core, begun before the rest of the page is read: that takes as long as a thread to begin.
import CoreWorker from "./worker?worker&inline";

declare global {
  interface Window {
    coreThread: Worker;
  }
}

window.coreThread = new CoreWorker();
