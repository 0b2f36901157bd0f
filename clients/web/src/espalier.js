// The entry of pages that hold a plant: espalier.showPlant.
export { showPlant } from "./view/plant_view.js";
