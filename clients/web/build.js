// Bundles src/studio.tsx into studio.js (also compressed, studio.js.gz) and studio.css, the page of a server, and src/espalier.js into espalier.js, the script
// of pages that hold a plant. The build of the program calls it, and so does the build of the Python package.
//
//     node build.js              bundle; fetch the packages first when they are missing
//     node build.js --packages   only fetch the packages
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const OLDEST_NODE = 18;

function fail(message) {
  console.error(message);
  process.exit(1);
}

// npm writes this file after it has installed everything
function arePackagesThere() {
  const installed = "node_modules/.package-lock.json";
  return existsSync(installed) && statSync(installed).mtimeMs >= statSync("package-lock.json").mtimeMs;
}

process.chdir(dirname(fileURLToPath(import.meta.url)));
if (Number.parseInt(process.versions.node, 10) < OLDEST_NODE) {
  fail(`Node.js ${process.versions.node} is too old: install version ${OLDEST_NODE} or newer.`);
}
if (!arePackagesThere()) {
  const done = spawnSync("npm", ["ci", "--loglevel=error"], { stdio: ["ignore", "ignore", "inherit"] });
  if (done.status !== 0) {
    fail("npm could not fetch the packages of the pages: look whether the npm registry can be reached, then try again.");
  }
}
if (!process.argv.includes("--packages")) {
  await import("../typescript/generate.js");
  const { build } = await import("esbuild");
  const common = {
    bundle: true,
    minify: true,
    format: "iife",
    legalComments: "eof",
    target: "es2022",
    tsconfig: "tsconfig.json",
    logLevel: "warning",
  };
  await Promise.all([
    build({ ...common, entryPoints: ["src/espalier.js"], globalName: "espalier", outfile: "espalier.js" }),
    build({ ...common, entryPoints: ["src/studio.tsx"], outfile: "studio.js" }),
  ]);
  // the file that a server sends to browsers
  writeFileSync("studio.js.gz", gzipSync(readFileSync("studio.js"), { level: 9 }));
}
