// The page of a server: it chooses or creates a simulation, steps and runs it, and shows its growth.
import { Connection } from "./connection.js";
import { PlantScene, boxOf } from "./plant_scene.js";

const REFRESH_MILLISECONDS = 2000;
const ROWS = 200;

const part = (id) => document.getElementById(id);

class LivePage {
  constructor() {
    this.simulation = null; // identifier of the shown simulation
    this.streams = {}; // identifiers: geometry, statistics
    this.isRunning = false;
    this.isStepping = false; // this page waits for a step
    this.shownStep = -1;
    this.drawing = Promise.resolve();
    try {
      this.view = new PlantScene(part("plant"));
    } catch (error) {
      this.say(`This page cannot draw: WebGL is not available (${error.message}).`, true);
    }
    part("token-form").onsubmit = (event) => this.handle(event, () => this.connect(part("token").value));
    part("gallery").onchange = () => this.chooseModel();
    part("create-form").onsubmit = (event) => this.handle(event, () => this.create());
    part("simulations").onchange = () => this.handle(null, () => this.choose(part("simulations").value));
    part("step").onclick = () => this.handle(null, () => this.step());
    part("run").onclick = () => this.handle(null, () => (this.isRunning ? this.act("simulation.pause") : this.run()));
    part("reset").onclick = () => this.handle(null, () => this.reset());
    part("delete").onclick = () => this.handle(null, () => this.delete());
  }

  say(text, isError = false) {
    part("message").textContent = text;
    part("message").className = isError ? "error" : "";
  }

  /** Runs an action of the user and shows its error on the page. */
  async handle(event, action) {
    event?.preventDefault();
    this.say("");
    try {
      await action();
    } catch (error) {
      this.say([error.message, ...(error.data?.diagnostics ?? []).map((item) => item.text ?? item.message)].join("\n"), true);
    }
    this.showButtons();
  }

  async connect(token = new URLSearchParams(location.hash.slice(1)).get("token") ?? "") {
    const address = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/espalier/1`;
    try {
      this.connection = await Connection.open(
        address, token, (method, params, blocks) => this.notified(method, params, blocks), () => this.lost());
    } catch (error) {
      // 1003: the server needs a token
      part("token-form").hidden = error.code !== 1003;
      throw error.code === 1003 && !token ? new Error("This server needs a token.") : error;
    }
    part("token-form").hidden = true;
    part("controls").hidden = false;
    part("server").textContent = this.connection.server.server;
    const { gallery, entries = gallery } = await this.connection.call("model.list");
    part("gallery").replaceChildren(
      ...entries.map((name) => new Option(name, name)), new Option("your own model …", ""));
    this.chooseModel();
    await this.list();
    const named = new URLSearchParams(location.hash.slice(1)).get("simulation");
    if (named) {
      await this.choose(named);
    }
    document.body.dataset.state = "connected";
  }

  lost() {
    document.body.dataset.state = "lost";
    this.say("The connection to the server is lost. Trying again …", true);
    this.streams = {};
    const again = async () => {
      try {
        await this.connect(part("token").value || undefined);
        this.say("");
        if (this.simulation) {
          await this.choose(this.simulation);
        }
      } catch (error) {
        setTimeout(again, REFRESH_MILLISECONDS);
      }
    };
    setTimeout(again, REFRESH_MILLISECONDS);
  }

  chooseModel() {
    part("source").hidden = part("gallery").value !== "";
  }

  /** Updates the list of simulations: other programs make and delete them too. */
  async list() {
    const { simulations } = await this.connection.call("simulation.list");
    const options = simulations.map(({ simulation, name, step, running, damaged }) => {
      const state = damaged ? "damaged" : `step ${step}${running ? ", running" : ""}`;
      return new Option(`${name || simulation} (${state})`, simulation, false, simulation === this.simulation);
    });
    const none = new Option(options.length ? "choose …" : "none yet", "", !this.simulation, !this.simulation);
    part("simulations").replaceChildren(none, ...options);
    const shown = simulations.find(({ simulation }) => simulation === this.simulation);
    // a step of this page is not a run that can be paused
    this.isRunning = !this.isStepping && (shown?.running ?? false);
    this.showButtons();
  }

  async create() {
    const gallery = part("gallery").value;
    const params = gallery ? { model: { gallery }, name: gallery } : { model: { source: part("source").value } };
    if (part("seed").value !== "") {
      params.seed = Number(part("seed").value);
    }
    const processes = part("environment").value.trim();
    if (processes !== "") {
      params.environment = processes.startsWith("[") ? JSON.parse(processes) : [{ type: processes }];
    }
    const { simulation } = await this.connection.call("simulation.create", params);
    await this.choose(simulation);
  }

  async choose(simulation) {
    for (const stream of Object.values(this.streams)) {
      await this.connection.call("stream.close", { stream }).catch(() => {});
    }
    this.streams = {};
    this.simulation = simulation || null;
    this.shownStep = -1;
    this.view && (this.view.fitted = null);
    part("steps").replaceChildren();
    part("state").textContent = "";
    this.view?.show(null);
    if (this.simulation) {
      location.hash = `simulation=${encodeURIComponent(simulation)}`;
      // with one credit the server sends one frame at a time and skips steps in between
      const open = async (what, more) => {
        const { stream } = await this.connection.call("stream.open", { simulation, what, ...more });
        this.streams[what] = stream;
      };
      // a fast model makes more steps than a page can list
      await open("statistics", { maxHz: 20 });
      await open("geometry", { bin: true, credits: 1 });
    }
    await this.list();
  }

  notified(method, params, blocks) {
    if (method === "stream.end" && Object.values(this.streams).includes(params.stream)) {
      this.streams = {};
      this.simulation = null;
      this.say(`The stream has ended: ${params.reason}.`);
      this.handle(null, () => this.list());
    } else if (method === "stream.data" && blocks.glb) {
      this.drawing = this.drawing.then(() => this.draw(params, blocks.glb));
    } else if (method === "stream.data" && params.statistics) {
      this.addRow(params);
    }
  }

  async draw(params, words) {
    if (this.view && params.simulation === this.simulation) {
      try {
        const plant = await this.view.read(words.slice().buffer);
        this.view.show(plant);
        this.view.fitGrown(boxOf(plant));
        part("plant").dataset.step = String(params.step);
      } catch (error) {
        this.say(`The plant cannot be drawn: ${error.message}`, true);
      }
    }
    this.connection.notify("stream.ack", { stream: params.stream, sequence: params.sequence });
  }

  addRow({ step, statistics, finished }) {
    const cells = [step, statistics.modules, statistics.queries, statistics.milliseconds.toFixed(1)];
    const row = document.createElement("tr");
    row.append(
      ...cells.map((value) => Object.assign(document.createElement("td"), { textContent: Number(value).toLocaleString("en") })));
    // back at an earlier step: remove the later rows
    if (step <= this.shownStep) {
      part("steps").replaceChildren();
    }
    this.shownStep = step;
    part("steps").prepend(row);
    while (part("steps").childElementCount > ROWS) {
      part("steps").lastChild.remove();
    }
    part("state").textContent = finished ? `step ${step}, finished` : `step ${step}`;
    if (finished) {
      this.isRunning = false;
      this.showButtons();
    }
  }

  async act(method, params = {}) {
    await this.connection.call(method, { simulation: this.simulation, ...params });
    await this.list();
  }

  async step() {
    this.isStepping = true;
    this.showButtons();
    try {
      await this.connection.call("simulation.step", { simulation: this.simulation });
    } finally {
      this.isStepping = false;
      this.showButtons();
    }
    await this.list();
  }

  async run() {
    this.isRunning = true;
    this.showButtons();
    try {
      await this.act("simulation.run");
    } finally {
      this.isRunning = false;
    }
  }

  async reset() {
    await this.act("simulation.reset");
    // choose it again, so that the picture fits the small plant
    await this.choose(this.simulation);
  }

  async delete() {
    const gone = this.simulation;
    await this.choose("");
    await this.connection.call("simulation.delete", { simulation: gone });
    await this.list();
  }

  showButtons() {
    for (const id of ["step", "run", "reset", "delete"]) {
      part(id).disabled = !this.simulation || this.isStepping || (this.isRunning && id !== "run");
    }
    part("run").textContent = this.isRunning ? "Pause" : "Run";
  }
}

/** Turns the document into the page of its server. */
export function showServer() {
  const page = new LivePage();
  page.handle(null, () => page.connect());
  // other programs step and delete simulations too
  setInterval(() => {
    if (page.connection?.socket.readyState === WebSocket.OPEN && document.activeElement !== part("simulations")) {
      page.list().catch(() => {});
    }
  }, REFRESH_MILLISECONDS);
  return page;
}
