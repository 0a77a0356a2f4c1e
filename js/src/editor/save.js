/** Takes the word away: CSS and Python for the clipboard, SVG and PNG as files. */
import { layers } from "../view/colour.js";
import { windowFor } from "../view/drawing.js";
import { pathData } from "../view/path.js";
import { isArray } from "../word/decode.js";

/** @typedef {import("./session.js").Session} Session @typedef {import("../word/forward.js").Layout} Layout */

/** Height of a saved PNG, in pixels. */
const PNG_HEIGHT = 1000;

const rounded = (/** @type {number} */ value) => Math.round(value * 1e4) / 1e4;

/** As `Text.to_css`. @param {Session} session */
function css({ axes, word }) {
  const settings = (/** @type {Record<string, number>} */ values) =>
    Object.entries(values).map(([tag, value]) => `"${tag}" ${rounded(value)}`).join(", ");
  const family = `font-family: ${JSON.stringify(word?.family ?? "")};`;
  if (!isArray(axes)) return `${family}\nfont-variation-settings: ${settings(axes)};`;
  return [family, ...axes.map((values, i) => `.letter-${i + 1} { font-variation-settings: ${settings(values)}; }`)].join("\n");
}

/** The axes as a Python literal. @param {Session} session */
function python({ axes }) {
  return `axes = ${JSON.stringify(axes, (_, value) => (typeof value === "number" ? rounded(value) : value))}`;
}

/** An SVG document, as `Text.to_svg`. @param {Layout} layout */
function svg(layout) {
  const { x, y, width, height } = windowFor(layout), { string, family } = layout.word;
  const title = `${string} in ${family}`.replace(/[&<>]/g, (c) => `&#${c.charCodeAt(0)};`);
  const paths = layout.row.order.map((_, i) =>
    `<g transform="translate(${rounded(layout.x[i])} ${rounded(-layout.y[i])})">${
      layers(layout, i).map(({ outerHTML }) => outerHTML).join("") || `<path d="${pathData(layout, i)}"/>`}</g>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="${[x, y, width, height].map(rounded).join(" ")}" width="${
    Math.round(PNG_HEIGHT * width / height)}" height="${PNG_HEIGHT}"><title>${title}</title>${paths.join("")}</svg>`;
}

/** @param {string} text */
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // A page that is not served securely has no clipboard of its own.
    const area = Object.assign(document.createElement("textarea"), { value: text });
    document.body.append(area);
    area.select();
    const copied = document.execCommand("copy");
    area.remove();
    if (!copied) throw new Error("the browser does not give access to the clipboard");
  }
}

/** @param {string} name @param {string} url */
function download(name, url) {
  Object.assign(document.createElement("a"), { download: name, href: url }).click();
}

/** @param {string} document */
const address = (document) => `data:image/svg+xml;charset=utf-8,${encodeURIComponent(document)}`;

/** @param {Layout} layout */
const saveSvg = (layout) => download("word.svg", address(svg(layout)));

/** @param {Layout} layout */
async function savePng(layout) {
  const image = new Image();
  image.src = address(svg(layout));
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
  canvas.getContext("2d")?.drawImage(image, 0, 0);
  download("word.png", canvas.toDataURL());
}

/**
 * @param {string} what the entry of the menu @param {Session} session @param {Layout | null} layout
 * @param {(kind: string, words: string) => void} say hears of the result
 */
export async function save(what, session, layout, say) {
  if (layout === null) return;
  try {
    if (what === "Copy CSS") await copy(css(session));
    else if (what === "Copy Python") await copy(python(session));
    else if (what === "Save SVG") saveSvg(layout);
    else await savePng(layout);
    say("idle", what.startsWith("Copy") ? "Copied." : "Saved.");
  } catch (error) {
    say("error", `${what} failed: ${/** @type {Error} */ (error).message}.`);
  }
}
