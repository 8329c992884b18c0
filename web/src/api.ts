// What the server of `ricochet view` answers. Numbers arrive as they leave the library: scaled, to the last bit.
import { saved, savedOrbit, savedSource } from "./saved";

export interface BranchRow {
  id: number;
  label: string;
  word: string;
  impacts: number;
  symmetric: boolean;
  reversible: boolean;
  mirror: string;
  stable_fraction: number | null;
  points: number;
  energy_min: number;
  energy_max: number;
  frequency_min: number;
  frequency_max: number;
  from: number | null;
  to: number | null;
  stop: string;
  why: string;
  tongues: string; // internal resonances that it follows, in words
  junctions: number[];
  junction_arclengths: number[];
  junction_levels: number[]; // on which duplicate each of these is drawn
  linear: boolean;
  linked: boolean; // a chain of junctions leads to a linear mode
  proved: number; // points with a proof that is kept
  curve_proved: boolean; // one arc from end to end, the same
  key: string;
  depth: number;
  mode: number | null;
  place: number; // of its first knot in the packed points
  knots: number;
}

export interface Departures {
  taken: number;
  known: number;
  inadmissible: number;
  over_budget: number;
  refused: number;
}

export interface JunctionRow {
  id: number;
  kind: string;
  label: string;
  name: string;
  word: string;
  impacts: number;
  grazings: number;
  multiple: number;
  rotation: [number, number] | null;
  a: number | null;
  b: number | null;
  energy: number;
  frequency: number;
  branches: number[];
  departures: Departures;
  budgets: Record<string, number>; // departures over each budget
  refusal: string;
  proved: boolean; // by a proof that is kept
}

export interface Contact {
  name: string;
  normal: number[];
  clearance: number | null;
  sides: string;
}

export interface Model {
  dofs: number;
  modes: number;
  length: number;
  units?: { length: string; time: string; force: string }; // where the study names them
  onset: number | null; // scaled energy of the first touch
  symmetric: boolean;
  frequencies: number[];
  locked: number[];
  shapes: number[]; // modes, mass-normalised, the columns of a square
  mass: number[];
  stiffness: number[];
  contacts: Contact[];
  faces: { contact: number; side: number }[];
}

export interface Drawing {
  nodes: { at: [number, number, number]; moves: [number, number, number] }[]; // displacements from 1; 0: none
  lines: [number, number][];
}

export interface Budgets {
  depth: number;
  impacts: number;
  multiply: number;
  energy: [number, number];
  frequency: [number, number];
}

export interface Description {
  generation: number;
  version: string;
  title: string;
  finished: boolean;
  other?: boolean; // there is an atlas to compare with
  response?: boolean; // and exact curves of the shaken structure
  model: Model;
  drawing: Drawing | null;
  forcing: { force: number[]; damping: number[]; restitution: number; harmonic: number; levels: number[] } | null; // of the study
  budgets: Budgets;
  regions: Budgets[]; // where larger ones hold; -1: as elsewhere
  branches: BranchRow[];
  junctions: JunctionRow[];
}

export interface Orbit {
  word: string;
  state: number[];
  flights: number[];
  period: number;
  frequency: number;
  energy: number;
  multipliers: [number | null, number | null][] | null; // null where rounding hides them, in pairs
  stable: "yes" | "no" | "undecided";
  amplitudes: number[] | null;
  impact_speeds: number[];
  impulses: number[];
  arclength: number;
  trace: number | null;
  rotation: number | null;
  reach: number | null;
  approach: number | null;
  residual: number;
  proved?: boolean; // of a stored point: a proof of it is kept
  impact_times: number[];
  impact_faces: number[];
  history: { t: number[]; x: number[][]; v: number[][] } | null;
}

export interface BaseRow {
  base: string;
  mode: number;
  j: number;
  number: number;
  branches: number[];
  labels: string[];
}

export interface CascadeRow {
  path: number;
  step: number;
  branch: number;
  junction: number | null;
  label: string | null;
  "p/q": string;
  impacts: number;
  energy: number | null;
  frequency: number | null;
  stop: string | null;
}

export interface Extension {
  running: boolean;
  undo: number; // extensions that can be taken back
  stopping: boolean;
  failed: boolean;
  message: string;
  branches: number;
  junctions: number;
  open: number;
  labels: number;
  depth: number;
  seconds: number;
}

export interface Status {
  generation: number;
  extension: Extension;
}

// The token comes with the address that the program prints, and leaves the address line at once: a picture of the screen does not give it away.
function takeToken(): string {
  const url = new URL(location.href);
  const given = url.searchParams.get("token");
  if (given !== null) {
    sessionStorage.setItem("token", given);
    url.searchParams.delete("token");
    history.replaceState(history.state, "", url.pathname + url.search + url.hash);
  }
  return sessionStorage.getItem("token") ?? "";
}

const token = saved ? "" : takeToken();
export const mayCompute = saved || token !== "";

async function failure(response: Response): Promise<Error> {
  const text = await response.json().then((answer) => (answer as { error: string }).error, () => `the server answered ${response.status}`);
  return Object.assign(new Error(text), { status: response.status });
}

async function request<T>(path: string, options: RequestInit = {}): Promise<T> {
  const response = await fetch(path, { ...options, headers: { "X-Ricochet-Token": token }, credentials: "omit" });
  if (!response.ok) throw await failure(response);
  return (await response.json()) as T;
}

const notSaved = (what: string) => Promise.reject(new Error(`A saved page has no ${what}: ricochet view ATLAS shows them.`));

export const getStatus = () => request<Status>("/api/status");
export const getBases = (): Promise<BaseRow[]> => saved ? notSaved("fractal bases") : request<BaseRow[]>("/api/bases");
export const getCascades = (): Promise<CascadeRow[]> => saved ? notSaved("cascades") : request<CascadeRow[]>("/api/cascades");
export const stopExtension = () => request<Extension>("/api/stop", { method: "POST", body: "{}" });
export const undoExtension = () => request<Extension>("/api/undo", { method: "POST", body: "{}" });
export interface Region {
  energy: [number, number];
  frequency: [number, number];
}
export const extend = (budgets: { depth?: number; impacts?: number; multiply?: number; seconds?: number } & Partial<Region>) =>
  request<Extension>("/api/extend", { method: "POST", body: JSON.stringify(budgets) });

export type Where = { point: number } | { energy: number } | { frequency: number } | { arclength: number };

export const getOrbit = (branch: number, where: Where, signal?: AbortSignal): Promise<Orbit[]> => {
  const [name, value] = Object.entries(where)[0] as [string, number];
  if (saved) return Promise.resolve(savedOrbit(branch, value));
  return request<Orbit[]>(`/api/orbit?branch=${branch}&${name}=${value}`, { signal });
};

export interface CurvePart {
  arclength: number[];
  energy: number[];
  frequency: number[];
}

// Orbits between stored points, in the order of the branch.
export const getCurve = (branch: number, from: number, to: number, count: number) => request<CurvePart>(`/api/curve?branch=${branch}&from=${from}&to=${to}&count=${count}`);

// A motion on a section: pairs of displacement and momentum at its impacts.
export interface SectionStart {
  branch?: number; // of an orbit of the atlas
  stable?: number;
  lyapunov: number | null; // per second
  lyapunov_error: number | null;
  rotation: number | null;
  why: string;
  faces: number[];
  places: number[];
}

export interface SectionAnswer {
  energy: number;
  modes: number;
  starts: SectionStart[];
  orbits: SectionStart[];
}

export const getSection = (ask: { energy: number; starts: number; impacts: number; orbits?: boolean; from?: { face: number; u: number; v: number } }) =>
  request<SectionAnswer>(`/api/section?energy=${ask.energy}&starts=${ask.starts}&impacts=${ask.impacts}${ask.orbits ? "&orbits=1" : ""}${ask.from ? `&face=${ask.from.face}&u=${ask.from.u}&v=${ask.from.v}` : ""}`);

// Thresholds along a branch; null: no work is done.
export interface ForceRow {
  arclength: number[];
  energy: number[];
  omega: number[];
  threshold: (number | null)[];
  stable: number[];
  why: string[]; // what forbids to trust it; ""
  amplitudes: number[][];
  turns: ForceTurn[];
}

// Where a detached resonance is born, a minimum of the threshold, or joins another, a maximum.
export interface ForceTurn {
  birth: boolean;
  arclength: number;
  energy: number;
  omega: number;
  threshold: number;
  why: string;
  error: number | null; // null: it is known to a stored point only
}

// Exact motions at one level of the force, over its frequency.
export interface ResponseCurve {
  id: number;
  level: number;
  impacts: number;
  periods: number;
  closed: boolean;
  omega: number[];
  stable: number[];
  peaks: number[][]; // of each displacement
}

export interface ResponseAnswer {
  finished: boolean;
  force: number[];
  damping: number[]; // empty: a matrix
  restitution: number;
  curves: ResponseCurve[];
}

export const getResponse = () => request<ResponseAnswer>("/api/response");

export const getForce = (branch: number, of: { force: number[]; damping: number[]; restitution: number; harmonic: number }) =>
  request<ForceRow>(`/api/force?branch=${branch}&harmonic=${of.harmonic}&restitution=${of.restitution}&force=${of.force.join(",")}&damping=${of.damping.join(",")}`);

// Points of branches. An outline has some of them, and says at its end how many of each branch.
export interface Source {
  description: Description;
  packed: ArrayBuffer;
  outline: boolean;
}

async function getPacked(path: string): Promise<{ packed: ArrayBuffer; generation: number }> {
  const response = await fetch(path);
  if (!response.ok) throw await failure(response);
  return { packed: await response.arrayBuffer(), generation: Number(response.headers.get("X-Ricochet-Generation")) };
}

// Description and outline of one generation: when the atlas changes in between, both are asked for again.
export async function getAtlas(): Promise<Source> {
  if (saved) return savedSource();
  for (;;) {
    const [description, { packed, generation }] = await Promise.all([request<Description>("/api/atlas"), getPacked("/api/outline")]);
    if (generation === description.generation) return { description, packed, outline: true };
  }
}

// The atlas to compare with, with all points.
export async function getOther(): Promise<Source> {
  const [description, { packed }] = await Promise.all([request<Description>("/api/other/atlas"), getPacked("/api/other/points")]);
  return { description, packed, outline: false };
}

export const getOtherOrbit = (branch: number, arclength: number) => request<Orbit[]>(`/api/other/orbit?branch=${branch}&arclength=${arclength}`);

// The same with all points; null: the atlas has changed meanwhile.
export async function getPoints(of: Source): Promise<Source | null> {
  const { packed, generation } = await getPacked("/api/points");
  return generation === of.description.generation ? { description: of.description, packed, outline: false } : null;
}
