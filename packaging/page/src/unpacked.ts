/** The bytes of base64; the newest browsers do it at once. */
function bytes(base64: string): Uint8Array<ArrayBuffer> {
  const built = Uint8Array as unknown as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> };
  return built.fromBase64?.(base64) ?? Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

/** The stream behind base64 of gzip. */
export function unpacked(base64: string): ReadableStream<Uint8Array> {
  return new Blob([bytes(base64)]).stream().pipeThrough(new DecompressionStream("gzip"));
}
