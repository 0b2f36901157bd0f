// Bundles src/plant_view.js with three.js into one file that the Python package puts into its pages.
import { build } from "esbuild";

await build({
  entryPoints: ["src/plant_view.js"],
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "espalier",
  legalComments: "eof",
  target: "es2020",
  outfile: "../python/espalier/viewer/plant_view.js",
});
