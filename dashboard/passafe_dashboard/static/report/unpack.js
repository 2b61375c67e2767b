// Reads the arrays that run_record/packed_arrays.py packs: base64, deflate, differences, bytes of one weight together.

/** @param {string} text base64 of deflated bytes */
async function inflate(text) {
  const deflated = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Arrays of one run, each found by its offset. */
export class PackedArrays {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
  }

  /** @param {string} text */
  static async read(text) {
    return new PackedArrays(await inflate(text));
  }

  /** Returns `count` numbers, which begin at `offset`, as the unsigned integers that were packed.
   * @param {number} offset
   * @param {number} count */
  bits(offset, count) {
    const values = new Uint32Array(count);
    const [b0, b1, b2, b3] = [0, 1, 2, 3].map((weight) => 4 * offset + weight * count);
    const bytes = this.bytes;
    for (let i = 0, sum = 0; i < count; i += 1) {
      const folded = bytes[b0 + i] | (bytes[b1 + i] << 8) | (bytes[b2 + i] << 16) | (bytes[b3 + i] << 24);
      sum = (sum + ((folded >>> 1) ^ -(folded & 1))) | 0;
      values[i] = sum;
    }
    return values;
  }

  /** @param {number} offset
   * @param {number} count */
  floats(offset, count) {
    return new Float32Array(this.bits(offset, count).buffer);
  }

  /** Returns increasing times in seconds; the first is `start`.
   * @param {number} offset
   * @param {number} count
   * @param {number} start */
  times(offset, count, start) {
    const steps = this.bits(offset, count);
    const times = new Float64Array(count);
    for (let i = 0, sum = 0; i < count; i += 1) {
      sum += steps[i];
      times[i] = start + sum * 1e-6;
    }
    return times;
  }
}
