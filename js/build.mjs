// Builds what the Python package ships: vfwidget/static (the view) and vfwidget/fonts.
import { mkdir, copyFile, readdir, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { join } from "node:path";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const target = join(here, "..", "vfwidget");

// A saved notebook stores these scripts with every widget, so they have to stay small.
const stored = ["editor.js", "player.js"], maxStoredBytes = 60_000;

// Latin with every axis; "standard" holds every axis of the fonts that have no "full".
const fonts = {
  "afacad-flux": "standard",
  dynapuff: "standard",
  recursive: "full",
  "roboto-flex": "full",
  "shantell-sans": "full",
};

// A static font, whose letters a notebook matches; in a folder of its own, so that it is no
// bundled variable font.
const staticFont = "gfs-didot";

async function bundle(entry) {
  const { outputFiles } = await build({
    entryPoints: [join(here, "src", entry)],
    bundle: true,
    format: "esm",
    minify: true,
    target: "es2022",
    charset: "utf8",
    write: false,
    logLevel: "warning",
  });
  return outputFiles[0].contents;
}

async function emptyFolder(name) {
  const folder = join(target, name);
  await mkdir(folder, { recursive: true });
  for (const file of await readdir(folder)) await rm(join(folder, file), { recursive: true });
  return folder;
}

/** What is built, and from which source. */
const sources = {
  "editor.js": "index.js", "editor.css": "editor/editor.css", "tools.js": "tools.js", "page.js": "page.js",
  "player.js": "player.js", "player.css": "player/player.css",
};
const built = [];
for (const [name, source] of Object.entries(sources)) {
  const contents = await bundle(source);
  if (stored.includes(name) && contents.length > maxStoredBytes) {
    throw new Error(`${name} has ${contents.length} bytes; it may have ${maxStoredBytes}`);
  }
  built.push([name, contents]);
}

async function copyFont(source, file, folder, name) {
  await copyFile(join(source, "files", file), join(folder, `${name}.woff2`));
  await copyFile(join(source, "LICENSE"), join(folder, `${name}-LICENSE.txt`));
}

const packages = join(here, "node_modules");
const fontFolder = await emptyFolder("fonts");
for (const [name, set] of Object.entries(fonts)) {
  const source = join(packages, "@fontsource-variable", name);
  await copyFont(source, `${name}-latin-${set}-normal.woff2`, fontFolder, name);
}
await copyFont(
  join(packages, "@fontsource", staticFont),
  `${staticFont}-latin-400-normal.woff2`,
  await emptyFolder(join("fonts", "static")),
  staticFont,
);

const staticFolder = await emptyFolder("static");
for (const [name, contents] of built) await writeFile(join(staticFolder, name), contents);
console.log([...built.map(([name, { length }]) => `${name} ${length} bytes`), "6 fonts"].join(", "));
