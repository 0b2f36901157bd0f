// The interface for pages: espalier.showPlant; a script element with data-page="server" makes the page of a server.
import { showServer } from "./live_page.js";

export { showPlant } from "./plant_view.js";
export { showServer };

if (document.currentScript?.dataset.page === "server") {
  showServer();
}
