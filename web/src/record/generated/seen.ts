// Generated from crates/mission by `UPDATE=1 cargo test -p apex-mission typescript`. Do not edit.

/**
 * A scan line on the ground.
 */
export type SeenLine = { 
/**
 * Mission time in nanoseconds.
 */
t_ns: number, 
/**
 * Left end, `[longitude, latitude]` in degrees.
 */
left: [number, number], 
/**
 * Right end, `[longitude, latitude]` in degrees.
 */
right: [number, number], 
/**
 * True if the line counts: the attitude is known, the roll is within its limits, and no cloud hides the ground.
 */
valid: boolean, };

/**
 * The ground seen from the moment at which the scanner was switched on to the next gap.
 */
export type Swath = { 
/**
 * Scan lines by time. The ground between neighbours is seen.
 */
lines: Array<SeenLine>, };

/**
 * The outline of a picture on the ground.
 */
export type SeenPicture = { 
/**
 * Mission time in nanoseconds of the exposure.
 */
t_ns: number, 
/**
 * Corners, `[longitude, latitude]` in degrees.
 */
corners: Array<[number, number]>, };

/**
 * The ground seen in a stretch of a flight.
 */
export type Footprints = { 
/**
 * Swaths of the scanner by time.
 */
swaths: Array<Swath>, 
/**
 * Pictures by time.
 */
pictures: Array<SeenPicture>, };

/**
 * The score if the flight ended at an instant, in points.
 */
export type ScoreSoFar = { 
/**
 * Observations up to this instant count, nanoseconds of mission time: while the scanner is on, the last minute may be missing.
 */
counted_ns: number, 
/**
 * Points of all looks.
 */
benefits: number, 
/**
 * Crew, risk of failure, and required looks that are still missing.
 */
costs: number, 
/**
 * Benefits less costs.
 */
score: number, };
