/** Rows of glyphs: which one a word has at a place, and where its letters stand in it. No DOM. */

/**
 * @typedef {{default: number, regions: number[], deltas: ArrayLike<number>}} Form  default + Σ γ_region · delta
 * @typedef {{x: Form, y: Form}} Step
 * @typedef {object} Row
 * @property {number[]} order the glyph of each letter
 * @property {number[]} clusters the first character that each letter stands for
 * @property {string[]} names what each letter is called
 * @property {number[]} lines the line that each letter is on
 * @property {number[]} bases 1 for a letter, 0 for a mark
 * @property {number[]} anchors for each letter and then each end of a line the letter it is placed next to, or −1
 * @property {number[]} gaps how many letters stand before each on its line
 * @property {[letter: number, share: number][][]} pushed the advances before each
 * @property {Step[]} own the displacement of each from its anchor: the part by its own scalars,
 * @property {Step[]} anchored and the part by those of its anchor
 */

const F2DOT14 = 16384;

/** The index of the row at normalized coordinates. @param {import("./decode.js").Word} word @param {ArrayLike<number>} w */
export function rowAt({ settings: { edges, cells } }, w) {
  let cell = 0;
  for (let i = 0; i < edges.length; i++) {
    const v = Math.round(w[i] * F2DOT14) / F2DOT14;
    cell = cell * (edges[i].length + 1) + edges[i].filter((edge) => edge < v).length;
  }
  return cells[cell];
}

/**
 * The row whose letters are taken from rows of their own, for letters that have axes of their own. A step between
 * two letters is half that of either's row. A letter whose row joins letters in another way stays with the first row.
 * @param {import("./decode.js").Word} word @param {number[]} choice the index of a row for each letter
 * @returns {Row}
 */
export function rowOf({ rows }, choice) {
  if (choice.every((index) => index === choice[0])) return rows[choice[0]];
  const usual = rows[0], same = rows.map(({ clusters }) => String(clusters) === String(usual.clusters));
  const chosen = usual.order.map((_, i) => (same[choice[i]] ? rows[choice[i]] : usual));
  const owner = usual.anchors.map((anchor, i) => chosen[i < chosen.length ? i : anchor] ?? usual);
  const take = (/** @type {(row: Row, i: number) => any} */ part) => owner.map(part);
  return {
    order: chosen.map((row, i) => row.order[i]), clusters: usual.clusters, names: usual.names, lines: usual.lines, bases: chosen.map((row, i) => row.bases[i]),
    anchors: take((row, i) => row.anchors[i]), gaps: take((row, i) => row.gaps[i]), pushed: take((row, i) => row.pushed[i]),
    own: take((row, i) => row.own[i]), anchored: take((row, i) => (chosen[row.anchors[i]] ?? row).anchored[i]),
  };
}

/** The value of a form. @param {Form} form @param {ArrayLike<number>} gamma */
export function valueOf({ default: sum, regions, deltas }, gamma) {
  for (let j = 0; j < regions.length; j++) sum += gamma[regions[j]] * deltas[j];
  return sum;
}

/** The ends of the lines that have letters, as indices of their entries. @param {Row} row */
export const ends = ({ lines, order }) => [...new Set(lines)].map((line) => order.length + line);

/** The letters and ends whose steps lead to one, itself included. @param {Row} row @param {number} index */
export function chain({ anchors }, index) {
  const found = [];
  for (let i = index; i >= 0; i = anchors[i]) found.push(i);
  return found;
}
