// Shapes of what the server sends: the page's setup (live/page.py) and the state now in each frame (live/page_state.py).

/** @typedef {[number, number]} Pair */

/** @typedef {{names: string[], border: Pair[], unsafe: Pair[], bounded: boolean, closed: boolean, moving: number | null}} Outline */

/** @typedef {{kind: "plane", points: number, outlines: Outline[], bounds: [Pair, Pair], velocities: number,
 *   outline?: Pair[], links?: Pair[]}} Plane */

/** @typedef {{name: string, column: string, low: number | null, high: number | null}} Joint */

/** @typedef {{kind: "joints", unit: string, joints: Joint[], velocities: number}} Joints */

/** @typedef {[number, number, number]} Spot */

/** @typedef {{kind: "space", links: Pair[], radii: number[], bounds: [Spot, Spot], levels: {name: string, height_m: number}[],
 *   balls: {name: string, centre: Spot, radius: number}[]}} Space */

/** @typedef {{points: Spot[], spheres: Spot[]}} Body */

/** @typedef {{axes: number, pairs: number[][], full: number[]}} DriveSetup */

/** @typedef {{layout: string, rows: number, window_s: number, tolerances: Record<string, number>, links: string[],
 *   networks: {name: string, title: string}[], statuses: Record<string, {meaning: string, background: string, text: string}>,
 *   bands: any, columns?: {ticks: string[], states: string[]}, scene?: Plane | Joints | Space, charts?: any[], drive?: DriveSetup | null,
 *   script?: string, input_unit?: string, scenario?: string}} Setup */

/** @typedef {{tone: string, headline: string, detail: string}} Words */

/** @typedef {{name: string, distance: number, unit: string, text: string, h: number, lowest_h: number | null,
 *   nearest: boolean}} Gap */

/** A barrier's direction in the plane of inputs, and how far the decision may still go that way.
 * @typedef {{name: string, point: number, towards: Pair, margin: number}} Held */

/** @typedef {{state_ms: number | null, from_robot_ms: number | null, to_robot_ms: number | null,
 *   command_ms: number | null, round_trip_ms: number | null}} Ages */

/** @typedef {{page: string | null, device: string, since_ms?: number} | null} Driver */

/** @typedef {{run: number, log: string | null, detail: string, outcome: string, words: string}} EndedRun */

/** @typedef {{state: string, run: number, scenario: string, mode: string, prediction: boolean, gatekeeper: boolean,
 *   rate_hz: number, recording: boolean,
 *   log: string | null, can: string[], scenarios: string[],
 *   processes: Record<string, {state: string, can: string[]}>, last: EndedRun | null, trouble: string}} Session */

/** @typedef {{liveness: {state: string, text: string}, server_ms: number, words: Words, ages?: Ages, gaps: Gap[],
 *   held: Held[], energy: any, run: number, scenario: any, filter: any, plant: any, worst: any, verdict: any,
 *   status_counts: Record<string, number>, mismatched_messages: number, processes: any[], topics: any[],
 *   stop: {id: string | null, source: string | null}, lease: any, links: any[], link_states: any[], events: any[],
 *   drive?: {driver: Driver, pages: number, lease?: any} | null, session?: Session | null}} Now */

/** @typedef {{layout: string, restart: boolean, lost: number, tables: {ticks: (number | null)[][],
 *   states: (number | null)[][]}, now: Now}} Frame */

export {};
