/* An animated PNG out of pictures of one size (Portable Network Graphics, Third Edition, W3C 2025, 11.3.6): the data of each picture as the browser has packed
 * it, put one after another into one file. */

const SIGNATURE = [137, 80, 78, 71, 13, 10, 26, 10];

let table: Uint32Array | null = null;

function crc(bytes: Uint8Array): number {
  if (!table) {
    table = new Uint32Array(256);
    for (let n = 0; n < 256; n++) {
      let c = n;
      for (let k = 0; k < 8; k++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
      table[n] = c;
    }
  }
  let c = 0xffffffff;
  for (const byte of bytes) c = table[(c ^ byte) & 255] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

function chunk(type: string, data: Uint8Array): Uint8Array<ArrayBuffer> {
  const out = new Uint8Array(12 + data.length);
  const view = new DataView(out.buffer);
  view.setUint32(0, data.length);
  for (let i = 0; i < 4; i++) out[4 + i] = type.charCodeAt(i);
  out.set(data, 8);
  view.setUint32(8 + data.length, crc(out.subarray(4, 8 + data.length)));
  return out;
}

// The header of a picture and its packed data.
function parts(png: Uint8Array): { header: Uint8Array; data: Uint8Array[] } {
  const view = new DataView(png.buffer, png.byteOffset, png.byteLength);
  const data: Uint8Array[] = [];
  let header = new Uint8Array(0);
  for (let at = SIGNATURE.length; at + 12 <= png.length; ) {
    const length = view.getUint32(at);
    const type = String.fromCharCode(...png.subarray(at + 4, at + 8));
    const body = png.slice(at + 8, at + 8 + length);
    if (type === "IHDR") header = body;
    if (type === "IDAT") data.push(body);
    at += 12 + length;
  }
  return { header, data };
}

// Frames one after the other, each for so many milliseconds, for ever.
export function animatedPng(frames: Uint8Array[], milliseconds: number): Blob {
  const first = parts(frames[0]).header;
  const size = new DataView(first.buffer, first.byteOffset);
  const out: Uint8Array<ArrayBuffer>[] = [Uint8Array.from(SIGNATURE), chunk("IHDR", first)];
  const words = (n: number, fill: (v: DataView) => void) => {
    const bytes = new Uint8Array(n);
    fill(new DataView(bytes.buffer));
    return bytes;
  };
  out.push(chunk("acTL", words(8, (v) => v.setUint32(0, frames.length))));
  let sequence = 0;
  frames.forEach((png, i) => {
    const { header, data } = parts(png);
    if (header.some((byte, k) => byte !== first[k])) throw new Error("the pictures of the motion differ in their kind");
    out.push(chunk("fcTL", words(26, (v) => {
      v.setUint32(0, sequence++);
      v.setUint32(4, size.getUint32(0));
      v.setUint32(8, size.getUint32(4));
      v.setUint16(20, Math.round(milliseconds));
      v.setUint16(22, 1000);
    })));
    for (const body of data)
      if (i === 0) out.push(chunk("IDAT", body));
      else {
        const numbered = new Uint8Array(4 + body.length);
        new DataView(numbered.buffer).setUint32(0, sequence++);
        numbered.set(body, 4);
        out.push(chunk("fdAT", numbered));
      }
  });
  out.push(chunk("IEND", new Uint8Array(0)));
  return new Blob(out, { type: "image/png" });
}
