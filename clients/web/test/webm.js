// Reads the times of a film.

/** When the pictures of a WebM file are shown, in milliseconds (RFC 9559). */
export function timesOf(bytes) {
  const times = [];
  const number = (at, isName) => {
    const length = Math.clz32(bytes[at]) - 23;
    let value = isName ? bytes[at] : bytes[at] & ((0x80 >> (length - 1)) - 1);
    for (let i = 1; i < length; ++i) {
      value = value * 256 + bytes[at + i];
    }
    return { value, next: at + length };
  };
  const read = (begin, end, cluster) => {
    for (let at = begin; at < end; ) {
      const name = number(at, true);
      const { value: size, next } = number(name.next, false);
      const last = Math.min(next + size, end);
      if (name.value === 0x18538067 || name.value === 0x1f43b675) {
        read(next, last, { time: 0 });
      } else if (name.value === 0xe7) {
        cluster.time = bytes.subarray(next, last).reduce((sum, byte) => sum * 256 + byte, 0);
      } else if (name.value === 0xa3) {
        times.push(cluster.time + Buffer.from(bytes).readInt16BE(next + 1));
      }
      at = last;
    }
  };
  read(0, bytes.length, { time: 0 });
  return times;
}
