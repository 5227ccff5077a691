/** What the server answers; docs/reference/server-api.md. Times are mission time in nanoseconds. */

export type TaskState = 'pending' | 'enabled' | 'ongoing' | 'interrupted' | 'terminated';
export type RecordStatus = 'complete' | 'live' | 'incomplete';

export interface Growth {
  end_ns: number;
  batches: number;
  status: RecordStatus;
}

export interface Mission extends Growth {
  mission: string | null;
  agent: string | null;
  vehicle: string | null;
  apex_version: string | null;
  record: string;
  epoch_utc: string | null;
  from_ns: number;
  end_reason: string | null;
  tasks: number;
  targets: number;
  score: number | null;
}

export interface Track {
  t_ns: number[];
  latitude_deg: (number | null)[];
  longitude_deg: (number | null)[];
  altitude_m: (number | null)[];
  heading_deg: (number | null)[];
  roll_deg: (number | null)[];
  ground_speed_mps: (number | null)[];
  fuel_kg: (number | null)[];
  recorded: number;
}

export interface Task {
  id: number;
  parent: number | null;
  tag: string;
  goal: string;
  state: TaskState;
  outcome: string | null;
  since_ns: number;
  created_ns: number;
  method: string | null;
  place: string | null;
}

export interface Tasks {
  at_ns: number;
  tasks: Task[];
  counts: Partial<Record<TaskState, number>>;
  left_out: number;
}

export interface Bar {
  task: number;
  state: TaskState;
  from_ns: number;
  to_ns: number;
}

export interface Lane {
  tag: string;
  goal: string;
  depth: number;
  tasks: number;
  active_ns: number;
  rows: Bar[][];
  left_out: number;
}

export interface Timeline {
  from_ns: number;
  to_ns: number;
  lanes: Lane[];
  left_out: number;
}

export interface EventRow {
  id: number;
  t_ns: number;
  kind: string;
  task: number | null;
  from_state: string | null;
  to_state: string | null;
  outcome: string | null;
  subject: string | null;
  text: string | null;
  place: string | null;
}

export interface Events {
  events: EventRow[];
  more: boolean;
}

export interface Cause extends EventRow {
  heading: string;
}

export interface Why {
  at_ns: number;
  task: Task;
  now: string;
  because: Cause[];
  left_out: boolean;
  children: Task[];
  explainer: { waiting?: unknown; blocked?: unknown } | null;
  explainer_error: string | null;
}

export interface TargetChange {
  t_ns: number;
  state: string;
  detail: string | null;
}

export interface Target {
  id: string;
  name: string;
  latitude_deg: number | null;
  longitude_deg: number | null;
  value: number | null;
  geometry: GeoJSON.Geometry | GeoJSON.Feature | GeoJSON.FeatureCollection | null;
  history: TargetChange[];
}

export interface Report {
  sections: { section: string; body: unknown }[];
}

export interface Snippet {
  name: string;
  line: number;
  first_line: number;
  lines: string[];
}
