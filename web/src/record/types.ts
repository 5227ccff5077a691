/** What the server answers; docs/reference/server-api.md. Generated from the record view and the explainer. */

export type * from './generated/explain';
export type * from './generated/view';
