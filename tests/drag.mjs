// Solves drags as the view does: {src, drags: [{word, axes, handle, pins, locks, target}]} on stdin, places on stdout.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const { src, drags } = JSON.parse(readFileSync(0, "utf8"));
const load = (name) => import(pathToFileURL(`${src}/${name}.js`).href);
const { decodeWord } = await load("word/decode");
const { Drag } = await load("solver/drag");

const answers = drags.map(({ word, axes, target, ...wishes }) => {
  const drag = new Drag(decodeWord(word), axes, wishes);
  const place = drag.to(target);
  return { ...place, cost: drag.cost };
});
process.stdout.write(JSON.stringify(answers));
