// Builds what the Python package ships: vfwidget/static (the view) and vfwidget/fonts.
import { mkdir, copyFile, readdir, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { join } from "node:path";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const target = join(here, "..", "vfwidget");

// Each widget instance stores its own copy of the bundle, so it has to stay small.
const maxBundleBytes = 60 * 1024;

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

// Names of fields that only our own classes read; no trait, message or element has one of them. Shorter names
// for them make the bundle 3 % smaller.
const ownFields = `session drawing layout positions inFlight waiting gestures channel toolbar listeners predicted
  perLetter catchUp onSilence finishKeys unitsPerEm gammas places starts residual jacobian guard follows problems
  vectors chains scalarsOf holds actions chosen placeOf word evaluate grab underline settle setWord
  resetAll setValues togglePin zoomStep lockIcon controls onAnswer onIdle expire typing previous
  selected write element position letters begin hover stale better tether request pressed pixel follow visible
  animation release bounds beyond toFont changed unpin overlay dragging busy announce onmove
  ending toggleLock resizes predict setShared setLocked gamma flush slopes sentAt saving lower upper pull press home cost slope active weight
  clock past future version missing columns advances parts constant side miss carry`.split(/\s+/);
// Further names of the editor alone.
const editorFields = `throttle apartLabel backdrop range kinks share held problem distance baseline timeout timer pause hold zoom
  last show undo redo pins touching restart before reset pointer window number origin frame apart constrain
  silence drawn steps marks`.split(/\s+/);

async function bundle(entry) {
  const names = entry === "index.js" ? [...ownFields, ...editorFields] : ownFields;
  const { outputFiles } = await build({
    entryPoints: [join(here, "src", entry)],
    bundle: true,
    format: "esm",
    minify: true,
    mangleProps: new RegExp(`^(${names.join("|")})$`),
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

/** The bundles of the views: the entry of each, and its style sheet. */
const views = { editor: ["index.js", "editor/editor.css"], player: ["player.js", "player/player.css"] };
const built = [];
for (const [name, [script, style]] of Object.entries(views)) {
  const js = await bundle(script);
  if (js.length >= maxBundleBytes) {
    throw new Error(`${name}.js has ${js.length} bytes; it must stay under ${maxBundleBytes}`);
  }
  built.push([`${name}.js`, js], [`${name}.css`, await bundle(style)]);
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
