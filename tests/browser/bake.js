/** A bake as `model/bake.py` makes one, of an outfit that stays as it is. */

const MEASURED = { miss_mm: 20, edge_mm: 1, inside_percent: 0.1 };
const REPORT = { minutes: 1, drapes: 64, before: MEASURED, after: MEASURED };

/** Tensors `basis`, `joints` and `weights` of a `static.safetensors`, with the metadata of a bake. */
export function bakeOf(file) {
  const length = Number(file.readBigUInt64LE(0));
  const header = JSON.parse(file.subarray(8, 8 + length).toString());
  const metadata = { static: header.__metadata__.static, report: JSON.stringify(REPORT) };
  const tensors = { __metadata__: metadata };
  const parts = [];
  let end = 0;
  for (const name of ["basis", "weights", "joints"]) {
    const [from, to] = header[name].data_offsets;
    parts.push(file.subarray(8 + length + from, 8 + length + to));
    tensors[name] = { ...header[name], data_offsets: [end, end + to - from] };
    end += to - from;
  }
  const text = JSON.stringify(tensors);
  const padded = Buffer.from(text.padEnd(Math.ceil(text.length / 8) * 8));
  const size = Buffer.alloc(8);
  size.writeBigUInt64LE(BigInt(padded.length));
  return Buffer.concat([size, padded, ...parts]);
}
