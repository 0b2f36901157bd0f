// What the pages use: espalier.showPlant, and for the page of a server a script element with data-page="server".
import { showServer } from "./live_page.js";

export { showPlant } from "./plant_view.js";
export { showServer };

if (document.currentScript?.dataset.page === "server") {
  showServer();
}
