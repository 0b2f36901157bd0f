// The entry of the page of a server.
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
root.replaceChildren();
render(<App studio={studio} />, root);
