// A WebM file of compressed pictures (RFC 8794, EBML; RFC 9559, Matroska): each picture has the time that it is meant to have, on a slow machine, too.

export interface CodedPicture {
  data: Uint8Array<ArrayBuffer>;
  milliseconds: number; // from the beginning
  isKey: boolean; // it needs no picture before it
}

type Bytes = Uint8Array<ArrayBuffer>;

const utf8 = new TextEncoder();

/** A big-endian number without leading zeros. */
function whole(value: number): Bytes {
  const bytes = [];
  for (let rest = value; rest > 0 || bytes.length === 0; rest = Math.floor(rest / 256)) {
    bytes.unshift(rest % 256);
  }
  return Uint8Array.from(bytes);
}

function real(value: number): Bytes {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
}

/** An element: its identifier, the length of its content in eight bytes, its content. */
function element(id: number, ...content: Bytes[]): Bytes {
  const name = whole(id);
  const size = content.reduce((sum, { length }) => sum + length, 0);
  const made = new Uint8Array(name.length + 8 + size);
  made.set(name);
  new DataView(made.buffer).setUint32(name.length, 0x01000000);
  new DataView(made.buffer).setUint32(name.length + 4, size);
  let at = name.length + 8;
  for (const part of content) {
    made.set(part, at);
    at += part.length;
  }
  return made;
}

/** Pictures from one key picture up to the next. */
function clusters(pictures: CodedPicture[]): Bytes[] {
  const begins = pictures.flatMap(({ isKey }, i) => (isKey ? [i] : []));
  return begins.map((begin, i) => {
    const time = Math.round(pictures[begin].milliseconds);
    const blocks = pictures.slice(begin, begins[i + 1]).map(({ data, milliseconds, isKey }) => {
      const since = Math.round(milliseconds) - time;
      // track 1, time since that of the cluster, flags
      return element(0xa3, Uint8Array.of(0x81, (since >> 8) & 255, since & 255, isKey ? 0x80 : 0), data);
    });
    return element(0x1f43b675, element(0xe7, whole(time)), ...blocks);
  });
}

/** The file; key pictures are at most half a minute apart. */
export function webmOf(pictures: CodedPicture[], codec: string, width: number, height: number, milliseconds: number): Blob {
  const head = element(0x1a45dfa3, element(0x4286, whole(1)), element(0x42f7, whole(1)), element(0x42f2, whole(4)), element(0x42f3, whole(8)),
    element(0x4282, utf8.encode("webm")), element(0x4287, whole(2)), element(0x4285, whole(2)));
  const app = utf8.encode("espalier");
  const information = element(0x1549a966, element(0x2ad7b1, whole(1_000_000)), element(0x4489, real(milliseconds)), element(0x4d80, app), element(0x5741, app));
  const picture = element(0xe0, element(0xb0, whole(width)), element(0xba, whole(height)));
  const track = element(0x1654ae6b, element(0xae, element(0xd7, whole(1)), element(0x73c5, whole(1)), element(0x83, whole(1)), element(0x86, utf8.encode(codec)), picture));
  return new Blob([head, element(0x18538067, information, track, ...clusters(pictures))], { type: "video/webm" });
}
