/** The server's answers; docs/reference/server-api.md. Generated from the types of the server and of the crates that it uses. */

export type * from './generated/explain';
export type * from './generated/seen';
export type * from './generated/server';
export type * from './generated/view';
