// The entry of the page of a server.
// first: the graphics card begins while the rest of this script is run
import { firstCanvas } from "./view/first_canvas.js";
import { render } from "preact";
import { App } from "./parts/app.js";
import { Studio } from "./studio/studio.js";
import "./style.css";

let theme: string | null = null;
try {
  theme = localStorage.getItem("theme");
} catch {
  // a page without storage follows the system
}
document.documentElement.dataset.theme = theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

const studio = new Studio();
// for tests and for people who look with the console
Object.assign(window, { studio });
const root = document.getElementById("studio")!;
// the server reads and grows the model while the page is made; a call from here would have a browser's tools parse all of this script again
queueMicrotask(() => void studio.start());
root.replaceChildren();
render(<App studio={studio} canvas={firstCanvas} />, root);
