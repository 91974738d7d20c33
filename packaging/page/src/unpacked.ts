/** The stream behind base64 of gzip. */
export function unpacked(base64: string): ReadableStream<Uint8Array> {
  const packed = atob(base64);
  const bytes = new Uint8Array(packed.length);
  for (let n = 0; n < packed.length; n++) bytes[n] = packed.charCodeAt(n);
  return new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
}
