// A ZIP archive of files as they are, without compression (APPNOTE.TXT of PKWARE, 6.3.10: local headers, then the directory).

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let sum = byte;
  for (let bit = 0; bit < 8; ++bit) {
    sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return sum >>> 0;
});

function checksum(bytes: Uint8Array): number {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum = TABLE[(sum ^ byte) & 255] ^ (sum >>> 8);
  }
  return (sum ^ 0xffffffff) >>> 0;
}

/** Little-endian numbers of 2 or 4 bytes. */
function packed(...numbers: Array<[value: number, bytes: 2 | 4]>): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(numbers.flatMap(([value, bytes]) => Array.from({ length: bytes }, (_, i) => (value >>> (8 * i)) & 255)));
}

const VERSION = 20;
const UTF8_NAMES = 0x0800;
const DATE = (1 << 5) | 1; // 1 January 1980: the same files give the same archive

/** The archive of files by name. */
export function archiveOf(files: Map<string, Uint8Array<ArrayBuffer>>): Blob {
  const pieces: BlobPart[] = [];
  const directory: BlobPart[] = [];
  let at = 0;
  let directorySize = 0;
  for (const [name, bytes] of files) {
    const path = new TextEncoder().encode(name);
    // version, flags, method 0 (stored), time, date, checksum, sizes, length of the name, length of extra data
    const common = packed([VERSION, 2], [UTF8_NAMES, 2], [0, 2], [0, 2], [DATE, 2], [checksum(bytes), 4], [bytes.length, 4], [bytes.length, 4], [path.length, 2], [0, 2]);
    const local = packed([0x04034b50, 4]);
    pieces.push(local, common, path, bytes);
    const entry = packed([0x02014b50, 4], [VERSION, 2]);
    const rest = packed([0, 2], [0, 2], [0, 2], [0, 4], [at, 4]); // comment, disk, attributes, place of the local header
    directory.push(entry, common, rest, path);
    directorySize += entry.length + common.length + rest.length + path.length;
    at += local.length + common.length + path.length + bytes.length;
  }
  const end = packed([0x06054b50, 4], [0, 2], [0, 2], [files.size, 2], [files.size, 2], [directorySize, 4], [at, 4], [0, 2]);
  return new Blob([...pieces, ...directory, end], { type: "application/zip" });
}
