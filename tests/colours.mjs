// Draws the layers of a word as the view does: {src, word, axes} on stdin, SVG elements of each letter on stdout.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const { src, word, axes } = JSON.parse(readFileSync(0, "utf8"));
const load = (name) => import(pathToFileURL(`${src}/${name}.js`).href);

class Element {
  constructor(tag) {
    Object.assign(this, { tag, attributes: [], children: [] });
  }

  setAttribute(name, value) {
    this.attributes.push([name, value]);
  }

  append(...children) {
    this.children.push(...children);
  }

  toString() {
    const attributes = this.attributes.map(([name, value]) => ` ${name}="${value}"`).join("");
    return `<${this.tag}${attributes}>${this.children.join("")}</${this.tag}>`;
  }
}
globalThis.document = { createElementNS: (_, tag) => new Element(tag) };

const { decodeWord } = await load("word/decode");
const { Layout } = await load("word/forward");
const { layers } = await load("view/colour");
const layout = new Layout(decodeWord(word)).evaluate(axes);
process.stdout.write(JSON.stringify(layout.glyphs.map((_, i) => layers(layout, i).map(String).join(""))));
