/** Tables as Parquet files, written in the browser. */

import { save } from './save';

/** A column: words, or numbers with null for none. */
export type TableColumn =
  | { name: string; type: 'STRING'; data: string[] }
  | { name: string; type: 'DOUBLE' | 'INT32'; data: (number | null)[] };

/** The bytes of a Parquet file with these columns, which have equal length. */
export async function parquet(columns: readonly TableColumn[]): Promise<ArrayBuffer> {
  const { parquetWriteBuffer } = await import('hyparquet-writer');
  return parquetWriteBuffer({ columnData: columns.map(column => ({ ...column })) });
}

/** Saves a table. */
export async function saveParquet(name: string, columns: readonly TableColumn[]): Promise<void> {
  save(name, 'application/vnd.apache.parquet', new Blob([await parquet(columns)]));
}
