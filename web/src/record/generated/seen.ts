// Generated from crates/mission by `UPDATE=1 cargo test -p apex-mission typescript`. Do not edit.

export type SeenLine = { t_ns: number, left: [number, number], right: [number, number], valid: boolean, };
export type Swath = { lines: Array<SeenLine>, };
export type SeenPicture = { t_ns: number, corners: Array<[number, number]>, };
export type Footprints = { swaths: Array<Swath>, pictures: Array<SeenPicture>, };
export type ScoreSoFar = { counted_ns: number, benefits: number, costs: number, score: number, };
