// Prints Parquet files as JSON, one line for each: {rows, schema, metadata}. hyparquet reads them, a library of others.
//   node tests/python/read_parquet.mjs MODULES FILE…     MODULES: the folder that has the package hyparquet
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { gunzipSync } from 'node:zlib';

const [modules, ...files] = process.argv.slice(2);
const { parquetMetadata, parquetReadObjects } = await import(
  pathToFileURL(createRequire(`${modules}/`).resolve('hyparquet')));
const compressors = { GZIP: (input) => new Uint8Array(gunzipSync(input)) };
const plain = (_, value) =>
  typeof value === 'bigint' ? Number(value)
  : value instanceof Uint8Array ? { hex: Buffer.from(value).toString('hex') }
  : ArrayBuffer.isView(value) ? Array.from(value) : value;

for (const name of files) {
  const bytes = readFileSync(name);
  const file = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const head = parquetMetadata(file);
  const rows = await parquetReadObjects({ file, compressors, utf8: false });
  const schema = head.schema.map(({ name, type, repetition_type, num_children }) => [name, type, repetition_type, num_children]);
  const metadata = Object.fromEntries((head.key_value_metadata ?? []).map(({ key, value }) => [key, value]));
  console.log(JSON.stringify({ rows, schema, metadata }, plain));
}
