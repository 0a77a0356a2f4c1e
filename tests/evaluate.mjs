// Evaluates words as the view does: {src, cases: [{word, axes}]} on stdin, points on stdout.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const { src, cases } = JSON.parse(readFileSync(0, "utf8"));
const load = (name) => import(pathToFileURL(`${src}/${name}.js`).href);
const { decodeWord } = await load("word/decode");
const { Layout } = await load("word/forward");

const answers = cases.map(({ word, axes }) => {
  const layout = new Layout(decodeWord(word)).evaluate(axes);
  return layout.points.flatMap((points, letter) =>
    Array.from({ length: points.length / 2 }, (_, i) =>
      [points[2 * i] + layout.x[letter], points[2 * i + 1] + layout.y[letter]]));
});
process.stdout.write(JSON.stringify(answers));
