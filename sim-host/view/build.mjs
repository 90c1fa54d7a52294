// Bundles src/ into the script of the page, and writes down of what it was made (the format of sha256sum).

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, "../src/view");
const licence = readFileSync(join(here, "LICENSE-three.txt"), "utf8");
await build({
  absWorkingDir: here,
  entryPoints: ["src/main.js"],
  outfile: join(out, "page.js"),
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2023",
  charset: "utf8",
  legalComments: "none",
  banner: { js: `/*! Holds three.js, whose licence is:\n${licence}*/` },
});

const sources = ["LICENSE-three.txt", "build.mjs", "package-lock.json", "package.json", ...readdirSync(join(here, "src")).map((name) => `src/${name}`)].sort();
const line = (path) => `${createHash("sha256").update(readFileSync(join(here, path))).digest("hex")}  ${path}\n`;
writeFileSync(join(out, "page.sha256"), [...sources, "../src/view/page.js"].map(line).join(""));
