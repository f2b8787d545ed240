// The types of the scripts' one namespace, and of the data that the package packs for them; nothing of it is loaded.

type Colours = {light: string, dark: string};
type Numbers = ArrayLike<number>;
/** x, y [m] and heading [rad] */
type Pose = number[];
/** A function that reads a column of a row of the live page. */
type Read = (row: Numbers) => number;
type Answer = {good: boolean, text: string};

/** The time that a page shows [s]. */
interface Clock {
  start: number, end: number, time: number, speed: number, playing: boolean;
  onChange(listener: (clock: Clock) => void): void;
  set(time: number): void;
  play(): void;
  pause(): void;
  toggle(): void;
}

// ---- scene.js

type Robot = {name: string, colour: string, shape: string, wheelSeparation: number | null, wheelRadius: number | null};
type Path = {x: Numbers, y: Numbers, closed?: boolean};
type Trail = {x: Numbers, y: Numbers, error?: Numbers, from: number, to: number};
type RobotState = {pose: Pose | null, wheels?: number[], torque?: number[] | null, limit?: number, trail?: Trail};
type SceneState = {robots: RobotState[], cart?: Pose, carts?: Pose[]};
interface Scene {
  draw(state: SceneState): void;
  fit(x: Numbers, y: Numbers, far?: boolean): void;
  setPath(path: Path | null): void;
  toWorld(px: number, py: number): number[];
  toScreen(x: number, y: number): number[];
  zoom(factor: number, pose: Pose | null): void;
  zoomed(): boolean;
  pan(dx: number, dy: number): void;
}

// ---- replay.js: what pages/replay_data.py packs; columns are packed numbers

type ReplayRun = Robot & {limit: number, columns: Record<string, string>};
type ReplayData = {
  start: number, end: number, trail: number, errorScale: number, path: {x: string, y: string}, runs: ReplayRun[],
};
interface Replay {
  scene: Scene, runs: {columns: Record<string, Float32Array>, stateAt(time: number): RobotState}[];
  cartsAt(time: number): Pose[];
  copyTo(canvas: HTMLCanvasElement): void;
  follow(view: View): void;
}

// ---- charts.js: what pages/page_parts.py packs; time, value and the parts of a deviation are places in columns

type ChartRun = Colours & {name: string, width: number, dash: number[]};
type ChartLine = {kind: 'reference' | 'value' | 'command' | 'difference', run: number, name: string, time: number,
  value: number, thinnedFrom?: number};
type Mark = {time: number, text: string};
type Chart = {figure: string, label: string, unit: string, bend: number, limits: {run: number, value: number}[],
  lines: ChartLine[]};
type ChartData = {
  start: number, end: number, runs: ChartRun[], reference: Colours, command: Colours, charts: Chart[],
  events: (Mark & {run: number})[], deviation: Record<'run' | 'time' | 'x' | 'y' | 'x_error' | 'y_error', number>[], columns: any[],
};
type Stroke = {colour: Colours, width: number, dash: number[]};
/** What all charts of a page share. */
interface View {
  data: ChartData, clock: Clock, off: Set<string>, several: boolean, range: number[], difference: boolean;
  hover: number | null;
  readonly zoomed: boolean;
  onChange(listener: (what?: string) => void): void;
  changed(what: 'range' | 'lines' | 'time'): void;
  setRange(low: number, high: number): void;
  toggle(key: string): void;
  keys(line: ChartLine): string[];
  shows(line: ChartLine): boolean;
  time(): number;
}

// ---- the live page: what dashboard/snapshot.py tells

type Entry = {
  name: string, kind: 'float' | 'int' | 'bool' | 'str' | 'array', unit: string, text: string, allowed: string,
  choices: string[], live: boolean, default: any, slider: any[],
};
type Parameters_ = {
  nodes: {role: string, name: string, values: Record<string, any>, entries: Entry[]}[],
  path: Path | null,
};
type Recording = {state: 'recording' | 'writing' | 'failed' | 'done', name: string, text?: string};
// The parameters of a lesson that a run has had since a time [s] of it, and those that count for its motion; its start.
type RunValues = {
  number: number, since: number, pose: number[] | null, values: Record<string, any>, motion: Record<string, any>,
};
type State = {
  nodes: {name: string, role: string, text: string, good: boolean, reasons: Record<string, number>}[],
  refused: number, unreadable: Record<string, number>, events: {stamp: number, text: string}[],
  ended: Record<string, string>, lesson: string, run: RunValues, changed_laws: string[], name: string,
  law: {gains: '' | 'shipped' | 'changed', file: string, before: string},
  recordings: Recording[], columns: string[], failure: string,
};
type Topic = {name: string, type: string, rate: number, last: string};
type Request_ = {do: string, [key: string]: any};

interface Live {
  columns: string[] | null;
  on(kind: 'columns', listener: (names: string[]) => void): void;
  on(kind: 'rows', listener: (rows: Float32Array[]) => void): void;
  on(kind: 'state', listener: (state: State) => void): void;
  on(kind: 'parameters', listener: (parameters: Parameters_) => void): void;
  on(kind: 'topics', listener: (topics: Topic[]) => void): void;
  on(kind: 'lessons', listener: (lessons: any[]) => void): void;
  on(kind: 'connection', listener: (open: boolean) => void): void;
  tell(kind: string, value: any): void;
  send(message: object): void;
  ask(request: Request_): Promise<Answer>;
  idle(): boolean;
  set(node: string, values: Record<string, any>): Promise<Answer>;
  answer(answer: [number, boolean, string]): void;
  rows(packed: [string, number]): void;
  state(state: State): void;
  parameters(parameters: Parameters_): void;
  topics(topics: Topic[]): void;
  lessons(lessons: any[]): void;
  column(name: string): Read;
  begin(): void;
}
interface Drawing {
  x?: number[], y?: number[], speed?: number[], most?: number;
  points: (number | string)[][];
  cursor: number[] | null;
}
interface LiveCharts {
  only(name: string, columns: string[] | null): void;
}
interface Stage {
  place(on: boolean): void;
  pointed(event: PointerEvent): number[];
  draw(drawing: Drawing | null): void;
  redraw(): void;
  reach(point: number[]): void;
  newest(): Numbers | null;
  path(): Path | null;
  toScreen(x: number, y: number): number[];
}
type SurfaceNumbers = {columns: number, rows: number, farthest: number, linear: number[], angular: number[]};
interface Surface {
  surface(numbers: SurfaceNumbers): void;
  choose(name: 'linear' | 'angular'): void;
  dot(distance: number, bearing: number): void;
}
interface Control {
  row: HTMLElement;
  show(value: any): void;
}

/** The namespace of all scripts. */
interface Mrc {
  // basics.js
  element<K extends keyof HTMLElementTagNameMap>(
    kind: K, name?: string, text?: string, properties?: object): HTMLElementTagNameMap[K];
  onChoice(field: any, act: () => void): void;
  colour(name: string): string;
  look(colours: Colours): string;
  onDark(listener: () => void): void;
  number(value: number, unit?: string, digits?: number): string;
  roundStep(value: number): number;
  withUnit(value: number, unit: string): string;
  unpack(text: string): Float32Array;
  indexAt(times: Numbers, time: number): number;
  // clock.js, scene.js, replay.js, report.js
  makeClock(start: number, end: number): Clock;
  makePlayer(clock: Clock): {play: HTMLButtonElement, bar: HTMLElement};
  drawMarks(plot: any, marks: Mark[], words: boolean, above?: boolean): void;
  markBars(marks: Mark[], clock: Clock): void;
  viewButtons(shown: any): HTMLElement;
  SHAPES: Record<string, number[][]>;
  makeScene(canvas: HTMLCanvasElement, options: {robots: Robot[], path: Path | null, errorScale?: number, plain?: boolean}): Scene;
  makeReplay(element: HTMLElement, data: ReplayData, clock: Clock): Replay;
  runData: ReplayData, clock: Clock, replay: Replay;
  // charts.js, chart_bar.js, deviation.js, search.js, study.js
  nearest(times: Numbers, time: number): number;
  sample(style: Stroke): SVGSVGElement;
  strokeOf(run: ChartRun): Stroke;
  switchOf(view: View, key: string, name: string, style: Stroke): {button: HTMLButtonElement, value: HTMLElement};
  showCharts(data: ChartData, clock: Clock): View;
  charts: View;
  chartBar(view: View, hosts: HTMLElement[]): void;
  drawDeviation(view: View, host: HTMLElement): void;
  search: any, study: any;
  // the live page
  live: Live, stage: Stage, socket: WebSocket;
  makeStage(canvas: HTMLCanvasElement, placed: (pose: Pose) => void, moved?: (pose: Pose) => void): Stage;
  makeCharts(container: HTMLElement, list: HTMLElement): LiveCharts;
  makeParameter(entry: Entry, send: (value: any) => Promise<Answer>): Control;
  makeParameters(container: HTMLElement): void;
  makePath(container: HTMLElement, canvas: HTMLCanvasElement): {clear(): void};
  path: {clear(): void};
  planPath(points: (number | string)[][], limits: Record<string, number>): Promise<any>;
  makeLessons(live: Live, panel: HTMLElement, button: HTMLElement, charts: LiveCharts): void;
  readAnswer(text: string, unit: string): number;
  fold(on: boolean): void;
  makeSurface(canvas: HTMLCanvasElement): Surface;
}

interface Window {
  mrc: Mrc;
}
declare const mrc: Mrc;
/** uPlot 1.6, bundled without its types. */
declare const uPlot: any;
