// Shapes of what a report reads: plans of charts (run_record/chart_plan.py), runs (run_record/run_payload.py), scenes.

/** @typedef {[number, number]} Pair */

/** @typedef {{table: string, column: string, label: string, style: number, dash: boolean, unit: string, hidden: boolean,
 *   choice: string}} PlannedLine */

/** @typedef {{key: string, title: string, unit: string, lines: PlannedLine[], kind: "lines" | "status" | "rows",
 *   note: string, zero: boolean, least_span: number, linear: number, choices: string[]}} ChartPlan */

/** Name and colour of each status and phase, by column and value.
 * @typedef {Record<string, Record<string, {name: string, colour: string}>>} Bands */

/** @typedef {{border: Pair[], unsafe: Pair[], closed: boolean, moving: number | null}} Outline */

/** @typedef {{kind: "plane", points: number, outlines: Outline[], outline?: Pair[], heading?: string | null,
 *   links?: Pair[], arrows?: boolean}} PlanePicture */

/** @typedef {{name: string, column: string, low: number | null, high: number | null}} Joint */

/** @typedef {{kind: "joints", unit: string, joints: Joint[]}} JointPicture */

/** @typedef {{label: string, start_s: number, end_s: number, offset_s?: number, scene: PlanePicture | JointPicture,
 *   packed: string, tables: Record<string, ConstructorParameters<typeof import("./signal_table.js").SignalTable>[0]>}} PackedRun */

/** What a chart reads of a table, of a run that is over or live.
 * @typedef {Pick<import("./signal_table.js").SignalTable, "has" | "envelope" | "at" | "range" | "start" | "end" | "gap">} Table */

/** @typedef {{label: string, tables: Record<string, Table>}} DrawnRun */

/** @typedef {Omit<PackedRun, "tables"> & {tables: Record<string, import("./signal_table.js").SignalTable>}} Run */

/** @typedef {{runs: PackedRun[], charts: ChartPlan[], descriptions: Record<string, string>, bands: Bands,
 *   cursor_s?: number}} ReportData */

export {};
