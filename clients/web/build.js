// Bundles src/espalier.js with three.js into espalier.js, the one script of all pages. It is in the repository, so that
// nothing but a C++ compiler is needed to build the program; a test bundles again and compares.
import { build } from "esbuild";

await build({
  entryPoints: ["src/espalier.js"],
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "espalier",
  legalComments: "eof",
  target: "es2020",
  outfile: process.argv[2] ?? "espalier.js",
});
