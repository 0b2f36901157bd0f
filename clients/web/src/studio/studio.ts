// The state of the studio: a connection, a document, its simulation, and what the page shows of them.
import { Code, ServerError, connect } from "espalier";
import type { Client, Diagnostic, FrameOf, Information, Simulation, Statistics } from "espalier";
import { nextFrame } from "../view/frames.js";
import type { View } from "../view/scene.js";
import type { ModelPalette } from "../view/colours.js";
import type { Picked } from "../view/measures.js";
import { definesOf, definesOfDocument, directionToViewer, fileOf, firstDocument, galleryDocument, newDocument, numberText, withProcesses, withText } from "./document.js";
import type { Define, Document } from "./document.js";
import { Beside } from "./beside.js";
import type { Growth } from "./beside.js";
import { Extras } from "./extras.js";
import { Fields } from "./fields.js";
import { Frames } from "./frames.js";
import { History } from "./history.js";
import { folderPalette } from "./palette.js";
import { Recolours } from "./recolours.js";
import { Watched } from "./watched.js";
import { unpacked } from "./share.js";
import { checkDocument, createPlant, isTokenRefused, keepText, keptOf, restored, textOfError, textOfSteps } from "./plants.js";
import type { Connection, EnvironmentEntry, GalleryEntry } from "./types.js";

const CHECK_MILLISECONDS = 250;
const LIST_MILLISECONDS = 2500;
// after a slider's last move, for what can wait
const REST_MILLISECONDS = 300;
// of stepping between two kept states, and between two pictures of a run
const STATE_MILLISECONDS = 80;
const MOST_RUN = 1_000_000;

export class Studio {
  connection: Connection = "connecting";
  server = "";
  gallery: GalleryEntry[] = [];
  saved: string[] | null = null; // models on the server's disk; null: it keeps none
  environments: EnvironmentEntry[] = [];
  simulations: Information[] = [];

  document: Document = newDocument();
  isChanged = false;
  openFile = "model.l";
  diagnostics: Diagnostic[] = [];
  isLive = true; // a change of the text grows the plant again
  message: { text: string; isError: boolean } | null = null;

  simulation: Simulation | null = null;
  isOwn = false; // this page made it, so this page may replace it
  private readonly isWatchLink = new URLSearchParams(location.hash.slice(1)).has("watch");
  isReadOnly = this.isWatchLink; // the link, or the token, only watches: the server lets this page change nothing
  seed = 7;
  step = 0;
  length = 0;
  isFinished = false;
  isRunning = false;
  pace = 0; // least milliseconds of a step in a run
  statistics: Statistics[] = [];
  picked: (Picked & { explanation: string | null }) | null = null;
  palette: ModelPalette | null = null;
  view: View | null = null;
  longWork: { stop: AbortController; name: string } | null = null; // beside the plant: a film, plants for an archive
  readonly extras = new Extras(this);
  readonly beside = new Beside(this);
  readonly fields = new Fields(this);
  readonly watched = new Watched(this);
  readonly frames = new Frames(this);
  private readonly recolours = new Recolours();
  /** Called when there is a connection, and when there is one again. */
  onConnected: () => void = () => {};
  /** Takes the last change of the shown text back, also a slider's; or makes it again. */
  onUndo: (isRedo: boolean) => void = () => {};

  /** For tests: derivations that were started, that are under way, the most at once; changes that are not done. */
  readonly counts = { derivations: 0, inFlight: 0, mostInFlight: 0, waiting: 0 };

  client!: Client;
  private token = "";
  private ownId = ""; // of the simulation that this page made last, also when the server has lost it
  private history = new History();
  private readonly listeners = new Set<() => void>();
  private work: Promise<void> = Promise.resolve(); // requests that change the simulation, one after the other
  private wanted: { values: Record<string, number>; isFinal: boolean } | null = null;
  private wantedStep: number | null = null;
  // the state of the last answer: frames of figures may come later, and tell of steps before it
  private answered = { step: 0, finished: false };
  private checking = 0;
  private slid = -Infinity; // when a slider moved last
  shownTitle = "";
  private isFollowing = false; // builds after each of many changes
  private isNewer = false;
  private isSame = true; // neither a text nor the environment was changed since the last build, but for numbers that sliders set

  // ---- listeners

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  changed(): void {
    this.listeners.forEach((listener) => listener());
  }

  say(text: string, isError = false): void {
    this.message = text ? { text, isError } : null;
    this.changed();
  }

  /** Runs an action of the user; an error is shown on the page. */
  async act(action: () => Promise<unknown> | unknown): Promise<void> {
    this.message = null;
    try {
      await action();
    } catch (error) {
      this.fail(error);
    }
    this.changed();
  }

  fail(error: unknown): void {
    if (error instanceof ServerError && error.data.diagnostics) {
      this.diagnostics = error.data.diagnostics as Diagnostic[];
      this.message = { text: "The model has errors. The problems are listed below the text.", isError: true };
    } else {
      this.connection = isTokenRefused(error) ? "token" : this.connection;
      this.message = { text: textOfError(error), isError: true };
    }
  }

  // ---- the server

  async start(token?: string): Promise<void> {
    const named = new URLSearchParams(location.hash.slice(1));
    const shown = this.isOwn ? this.ownId : this.watched.id;
    this.simulation = null; // of a connection before
    await this.connect(token ?? named.get("token") ?? "");
    if (this.connection !== "connected") {
      return;
    }
    if (!shown) {
      setInterval(() => this.isSliding || void this.list().catch(() => {}), LIST_MILLISECONDS);
    }
    // the content of the page counts, not its address; and the plant is asked for before the lists
    const opened = this.act(() => (!shown ? this.openHash(named) : this.isOwn ? this.build(this.step) : this.watch(shown)));
    await Promise.all([opened, this.readLists().catch((error) => this.fail(error))]);
    this.changed();
  }

  /** Reads the lists that the server offers. */
  private async readLists(): Promise<void> {
    const lists = [this.client.gallery(), this.client.call("environment.list", {}), this.client.simulations()] as const;
    const [{ entries, pictures, saved }, { environments }, simulations] = await Promise.all(lists);
    this.gallery = entries.map((name) => ({ name, picture: pictures[name] ?? null }));
    this.saved = saved ?? null;
    this.environments = environments as EnvironmentEntry[];
    this.simulations = simulations;
    this.changed();
  }

  private async openHash(named: URLSearchParams): Promise<void> {
    const seed = named.get("seed");
    this.seed = seed ? Number(seed) : this.seed;
    const watched = named.get("simulation") ?? named.get("watch");
    if (watched) {
      await this.watch(watched);
    } else if (named.get("model")) {
      const shared = await unpacked(named.get("model")!);
      this.seed = shared.seed;
      await this.openDocument(shared.document, shared.step);
    } else {
      const first = named.get("gallery");
      await (first ? this.openGallery(first, named.get("step") ? Number(named.get("step")) : undefined) : this.openDocument(await firstDocument(this.client)));
    }
  }

  private dial(token: string): Promise<Client> {
    return connect(location.origin, {
      name: "studio",
      roles: this.isWatchLink ? ["viewer"] : ["controller", "viewer"],
      ...(token ? { token } : {}),
      onConnection: (is) => this.connectionChanged(is),
      onRefused: (error) => this.refused(error, "The server does not take this token any more. Nothing is lost: the text stays in the page."),
    });
  }

  async connect(token: string): Promise<void> {
    try {
      this.client = await this.dial(token).catch(async (error) => {
        if (error instanceof ServerError) {
          throw error;
        }
        // a page that takes long to make says hello too late, and the server hangs up: again when it is made
        await this.frames.isStaged;
        return this.dial(token);
      });
    } catch (error) {
      this.refused(error as Error, token ? (error as Error).message : "This server needs a token. Its operator has one.");
      return;
    }
    this.token = token;
    this.message = null;
    this.connection = "connected";
    this.server = this.client.hello.server;
    this.isReadOnly = this.isWatchLink || this.client.hello.roles?.includes("controller") === false;
    this.onConnected();
  }

  private refused(error: Error, ofToken: string): void {
    const needsToken = error instanceof ServerError && error.code === Code.unauthorised;
    this.connection = needsToken ? "token" : "failed";
    this.message = { text: needsToken ? ofToken : error.message, isError: true };
    this.changed();
  }

  /** A server that was started anew may not have the simulation any more: the plant of the page's text, at its step. */
  private async regrow(): Promise<void> {
    await this.list();
    if (!this.simulations.some(({ simulation }) => simulation === this.simulation?.id)) {
      const { message } = this;
      await this.build(this.step);
      this.message = message?.text.startsWith("The simulation is gone") ? null : this.message;
    }
  }

  private connectionChanged(isConnected: boolean): void {
    this.connection = isConnected ? "connected" : "lost";
    if (!isConnected) {
      this.isRunning = false;
    } else {
      this.onConnected();
    }
    if (isConnected && this.isOwn && (this.simulation || this.ownId)) {
      void this.act(() => this.regrow());
    }
    this.changed();
  }

  async list(): Promise<void> {
    if (this.connection === "connected") {
      this.simulations = await this.client.simulations();
      this.changed();
      // the watched one is there again
      if (!this.simulation && this.watched.isAmong(this.simulations)) {
        await this.act(() => this.watch(this.watched.id));
      }
    }
  }

  /** A message of the Language Server Protocol, and the messages that come back. */
  async editorMessage(message: string): Promise<string[]> {
    const run = this.isOwn && this.simulation ? { simulation: this.simulation.id } : {};
    return (await this.client.call("editor.message", { message, ...run })).messages;
  }

  /** A file of the server's HTTP side. */
  async fetchFile(path: string): Promise<Blob> {
    const response = await fetch(path, this.token ? { headers: { Authorization: `Bearer ${this.token}` } } : {});
    if (!response.ok) {
      throw new Error((await response.text()).trim());
    }
    return response.blob();
  }

  // ---- the document

  async openGallery(name: string, step?: number): Promise<void> {
    await this.openDocument(await galleryDocument(this.client, name), step);
  }

  async openDocument(document: Document, step?: number): Promise<void> {
    this.watched.requireController();
    this.document = document;
    this.isChanged = false;
    this.openFile = fileOf(document.main);
    this.diagnostics = [];
    this.message = null;
    this.watched.id = "";
    this.recolours.clear();
    this.changed();
    await this.build(step);
  }

  get defines(): Define[] {
    return definesOfDocument(this.document);
  }

  /** The text of a file has changed. */
  edit(file: string, text: string): void {
    if (this.document.files[file] === text) {
      return;
    }
    this.document = withText(this.document, file, text);
    this.isSame = false;
    this.isChanged = true;
    this.changed();
    void this.check();
  }

  /** Many changes in a row, as by a drag: the plant of the newest text is grown, never two at a time. */
  editContinuously(file: string, text: string): Promise<void> {
    return this.follow(withText(this.document, file, text));
  }

  /** `isSame`: the plant is the same in its state. */
  private async follow(changes: Partial<Document>, isSame = false): Promise<void> {
    this.watched.requireController();
    this.document = { ...this.document, ...changes, gallery: null };
    this.isSame &&= isSame;
    this.isChanged = true;
    this.isNewer = true;
    this.changed();
    if (this.isFollowing) {
      return;
    }
    this.isFollowing = true;
    try {
      while (this.isNewer) {
        this.isNewer = false;
        await this.build(this.answered.finished ? undefined : this.answered.step, true);
      }
    } catch (error) {
      this.fail(error);
    } finally {
      this.isFollowing = false;
      this.changed();
    }
  }

  /** The colours of the folder have changed. */
  recolour(file: string, base64: string): Promise<void> {
    this.recolours.add(file, this.document.binary[file], base64, this.document.files);
    return this.showColours(file, base64);
  }

  /** Takes the last change of a colour or of the shown text back, or makes it again. */
  undo(isRedo: boolean): void {
    const taken = this.recolours.take(isRedo, this.document.files);
    if (taken) {
      void this.act(() => this.showColours(taken.file, taken.bytes));
    } else {
      this.onUndo(isRedo);
    }
  }

  private showColours(file: string, base64: string): Promise<void> {
    const done = this.follow({ binary: { ...this.document.binary, [file]: base64 } }, true);
    this.palette = folderPalette(this.document);
    this.view?.setPalette(this.palette);
    return done;
  }

  addFile(name: string): void {
    if (name && !(name in this.document.files)) {
      this.document = { ...this.document, files: { ...this.document.files, [name]: "" }, gallery: null };
    }
    this.openFile = name || this.openFile;
    this.changed();
  }

  /** The processes of the environment; null: none. The plant grows again among them. */
  setProcesses(environment: unknown[] | null): Promise<void> {
    return this.follow(withProcesses(this.document, environment));
  }

  /** Compiles the text a moment after the last change, and grows the plant when it is right. */
  private async check(): Promise<void> {
    const mine = ++this.checking;
    await new Promise((done) => setTimeout(done, CHECK_MILLISECONDS));
    if (mine !== this.checking || this.connection !== "connected") {
      return;
    }
    try {
      const { isValid, diagnostics } = await checkDocument(this.client, this.document);
      if (mine === this.checking) {
        this.diagnostics = diagnostics;
        this.changed();
        if (isValid && this.isLive) {
          await this.act(() => this.build(this.answered.finished && this.answered.step >= this.length ? undefined : this.answered.step));
        }
      }
    } catch (error) {
      this.fail(error);
      this.changed();
    }
  }

  // ---- the simulation

  /** Work that changes the simulation waits for the work before it. */
  inTurn(work: () => Promise<void>): Promise<void> {
    ++this.counts.waiting;
    const mine = this.work.then(work).finally(() => --this.counts.waiting);
    this.work = mine.catch(() => {});
    return mine;
  }

  /** Makes the simulation of the document and derives it to a step (default: to its end). `isKept`: a plant that stays the same keeps its state, also where it was pruned. */
  build(step?: number, isKept = false): Promise<void> {
    this.isRunning = false;
    return this.inTurn(async () => {
      const old = this.isOwn ? this.ownId : null;
      await keepText(this);
      const { document } = this;
      const isAgain = old !== null && this.shownTitle === document.title;
      const kept = isKept && this.isSame && isAgain && this.simulation ? await keptOf(this.simulation, document).catch(() => null) : null;
      this.isSame = true;
      const { history, statistics } = this;
      const grow = async () => {
        // in the place of the old one: pages that watch see the new one
        const simulation = await createPlant(this.client, kept?.document ?? document, this.seed, old ?? undefined, kept?.parameters);
        const state = kept && (await restored(simulation, kept));
        this.diagnostics = simulation.created!.diagnostics;
        this.shownTitle = document.title;
        if (!isAgain) {
          await this.beside.close();
        }
        await this.show(simulation, true, !isAgain);
        if (state) {
          Object.assign(this, { history, statistics });
          this.reached(state);
        }
        await this.advance(step ?? this.length);
      };
      await (isAgain ? this.frames.hold(grow) : grow());
    });
  }

  /** The plant that is shown, with its past. */
  growth(): Growth {
    const { document, isChanged, seed, step, length, isFinished, statistics, history, palette } = this;
    return { simulation: this.simulation!, document, isChanged, seed, step, length, isFinished, statistics, history, palette };
  }

  /** Shows another plant of this page, with its past. */
  async take({ simulation, palette: _, ...past }: Growth): Promise<void> {
    this.document = past.document;
    this.shownTitle = past.document.title;
    this.recolours.clear();
    await this.show(simulation, true, false);
    Object.assign(this, past);
    this.reached({ step: past.step, finished: past.isFinished });
    this.changed();
  }

  /** Shows a simulation that another program made. */
  async watch(id: string): Promise<void> {
    const simulation = this.client.simulation(id);
    const information = await this.watched.read(simulation);
    await this.inTurn(() => this.show(simulation, false, true, information));
  }

  private async show(simulation: Simulation, isOwn: boolean, isAnother: boolean, information?: Information): Promise<void> {
    await this.frames.close();
    this.simulation = simulation;
    this.isOwn = isOwn;
    this.ownId = isOwn ? simulation.id : this.ownId;
    this.history = new History();
    this.statistics = [];
    this.picked = null;
    this.reached({ step: information?.step ?? 0, finished: simulation.created?.finished ?? information?.finished ?? false });
    this.length = simulation.created?.derivationLength ?? information?.derivationLength ?? 0;
    this.view?.highlight(null);
    if (isAnother) {
      this.view?.forgetFit(directionToViewer(this.document));
    }
    // one round trip: the colours come before the first frame
    await Promise.all([this.takePalette(simulation), this.frames.open(simulation), this.extras.follow(simulation)]);
    this.frames.read();
    this.changed();
  }

  /** The colours of the simulation. */
  async takePalette(simulation: Simulation): Promise<void> {
    const { colours, isOfModel } = await simulation.get("palette");
    this.palette = (this.isOwn && folderPalette(this.document)) || { colours: colours!, isOfModel: isOfModel! };
    this.view?.setPalette(this.palette);
  }

  /** The server tells of a step. */
  stepped({ step, finished, statistics }: FrameOf<"statistics">): void {
    // it began anew, perhaps with other numbers or another model
    if (!this.isOwn && this.statistics.length > 0 && step <= this.step) {
      void this.watched.refresh().catch((error) => this.fail(error));
    }
    this.step = step;
    this.isFinished = finished;
    if (!this.isOwn) {
      this.answered = { step, finished }; // others work on it
    }
    this.length = Math.max(this.length, step);
    // a state that was restored has no figures of its step
    const known = statistics.milliseconds === 0 ? this.statistics.find((one) => one.step === step && one.modules === statistics.modules) : undefined;
    this.statistics = [...this.statistics.filter((one) => one.step < step), known ?? statistics];
    void this.fields.refresh().catch((error) => this.fail(error));
    this.changed();
  }

  // ---- time

  /** A slider moves, or moved a moment ago: what can wait leaves the page and the server to its plant. */
  get isSliding(): boolean {
    return this.frames.held !== null || performance.now() - this.slid < REST_MILLISECONDS;
  }

  /** The step of the last answer. */
  get answeredStep(): number {
    return this.answered.step;
  }

  private reached({ step, finished, ...said }: { step: number; finished: boolean; warnings?: string[]; printed?: string }): void {
    this.answered = { step, finished };
    this.step = step;
    this.isFinished = finished;
    this.message = textOfSteps(said) ? { text: textOfSteps(said), isError: false } : this.message;
  }

  /** Derives to a step, and keeps states on the way. */
  private async advance(until: number): Promise<void> {
    const simulation = this.simulation!;
    let kept = this.keep(simulation);
    let chunk = 1;
    let sinceKept = 0;
    while (this.answered.step < until && !this.answered.finished && this.simulation === simulation) {
      // the server saves the state, then makes the steps
      let begin = performance.now();
      const stepping = this.derive(() => simulation.stepUntil(Math.min(until, this.answered.step + chunk)));
      const [result] = await Promise.all([stepping, kept.then(() => (begin = performance.now()))]);
      const time = performance.now() - begin;
      const made = result.step - this.answered.step;
      this.reached(result);
      if (made === 0) {
        break;
      }
      sinceKept += time;
      chunk = Math.max(1, Math.min(1000, Math.round((chunk * STATE_MILLISECONDS) / 2 / Math.max(time, 1))));
      if (sinceKept > STATE_MILLISECONDS) {
        kept = this.keep(simulation);
        sinceKept = 0;
      }
      this.changed();
    }
    await kept;
    await this.keep(simulation);
  }

  private async derive<T>(request: () => Promise<T>): Promise<T> {
    ++this.counts.derivations;
    this.counts.mostInFlight = Math.max(this.counts.mostInFlight, ++this.counts.inFlight);
    try {
      return await request();
    } finally {
      --this.counts.inFlight;
    }
  }

  private async keep(simulation: Simulation): Promise<void> {
    const { step } = this.answered;
    if (this.isOwn && !this.history.has(step)) {
      this.history.add(step, await simulation.save());
    }
  }

  stepOnce(): Promise<void> {
    return this.inTurn(async () => {
      const simulation = this.simulation!;
      this.reached(await this.derive(() => simulation.step()));
      await this.keep(simulation);
      await this.beside.follow(this.answered.step);
    });
  }

  /** Derives until the end or a pause. */
  async run(): Promise<void> {
    this.isRunning = true;
    this.changed();
    try {
      if (this.answered.finished && this.isOwn) {
        await this.goTo(0);
      }
      for (let made = 0; this.isRunning && !this.answered.finished && made < MOST_RUN; ++made) {
        const begin = performance.now();
        await this.inTurn(async () => {
          await this.advance(this.answered.step + 1);
          await this.beside.follow(this.answered.step);
        });
        const rest = Math.max(this.pace - (performance.now() - begin), 0);
        await (rest > 4 ? new Promise((done) => setTimeout(done, rest)) : nextFrame());
      }
    } finally {
      this.isRunning = false;
      this.changed();
    }
  }

  async pause(): Promise<void> {
    this.isRunning = false;
    this.changed();
    await this.simulation?.pause();
  }

  /** Goes to a step: the newest wish counts. */
  goTo(step: number): Promise<void> {
    this.slid = performance.now();
    this.wantedStep = step;
    return this.inTurn(async () => {
      if (this.wantedStep === null || !this.simulation) {
        return;
      }
      const target = this.wantedStep;
      this.wantedStep = null;
      if (target < Math.max(this.step, this.answered.step)) {
        const state = this.history.before(target);
        const figures = this.statistics;
        this.reached(state ? await this.simulation.restore(state.snapshot) : await this.simulation.reset(this.seed));
        this.statistics = figures;
      }
      await this.advance(target);
      await this.beside.follow(this.answered.step);
    });
  }

  setSeed(seed: number): Promise<void> {
    this.seed = seed;
    return this.inTurn(async () => {
      const until = this.answered.finished ? this.length : this.answered.step;
      this.reached(await this.simulation!.reset(seed));
      this.history.clear();
      this.statistics = [];
      await this.advance(until);
    });
  }

  /** A slider moves: only the newest value is derived. The text follows; it is built anew only for other changes. */
  slide(define: Define, value: number, sliderStep: number, isFinal: boolean): void {
    const text = this.document.files[define.file], written = numberText(value, sliderStep);
    // where the number is now: the slider may move again before the page has drawn its last move
    const { from, to } = definesOf(define.file, text).find(({ line }) => line === define.line) ?? define;
    const files = { ...this.document.files, [define.file]: text.slice(0, from) + written + text.slice(to) };
    this.document = { ...this.document, files, gallery: null };
    this.isChanged = true;
    const isUnderWay = this.wanted !== null;
    this.slid = performance.now();
    this.wanted = { values: { ...this.wanted?.values, [define.name]: Number(written) }, isFinal };
    this.changed();
    if (!isUnderWay) {
      void this.act(() => this.inTurn(() => this.deriveWanted()));
    }
  }

  private async deriveWanted(): Promise<void> {
    const simulation = this.simulation;
    const wish = this.wanted;
    this.wanted = null;
    if (!simulation || !wish) {
      return;
    }
    const until = this.answered.finished ? MOST_RUN : this.answered.step;
    await this.frames.hold(() =>
      this.derive(async () => {
        // one round trip: the server does them in order
        const requests = [simulation.set(wish.values), simulation.reset(this.seed), until === MOST_RUN ? simulation.run() : simulation.stepUntil(until)] as const;
        const [, , result] = await Promise.all(requests);
        this.reached(result);
        this.length = Math.max(this.length, result.step);
      }),
    );
    this.slid = performance.now();
    this.history.clear();
    this.diagnostics = this.diagnostics.filter(({ severity }) => severity !== "error");
  }

  // ---- one module

  async pick(found: Picked | null): Promise<void> {
    this.picked = found ? { ...found, explanation: null } : null;
    this.view?.highlight(found);
    this.changed();
    if (found && this.simulation) {
      const { explanation } = await this.simulation.get("explanation", { plant: found.plant, module: found.module });
      if (this.picked?.module === found.module) {
        this.picked = { ...this.picked, explanation: explanation ?? null };
        this.changed();
      }
    }
  }

  /** Prunes, bends or inserts at the chosen module. */
  change(action: "prune" | "insert", modules: Array<{ symbol: string; parameters: number[] }> = []): Promise<void> {
    const { plant, module } = this.picked!;
    return this.inTurn(async () => {
      await this.simulation!.edit({ plant, module, action, ...(modules.length ? { modules } : {}) });
      this.picked = null;
      this.view?.highlight(null);
      // states before the change remain reachable; those after it are of another plant
      this.history.clear();
      await this.keep(this.simulation!);
    });
  }
}
