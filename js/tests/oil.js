/** A small word to test with: "oil" set in two glyphs, two axes, two regions. */

/** @param {number[]} values */
export const floats = (values) => new DataView(Float32Array.from(values).buffer);

const quarter = 0.5523;

/** A closed contour of lines as cubics. @param {[number, number][]} corners */
function polygon(corners) {
  return corners.flatMap(([x, y], i) => {
    const [nx, ny] = corners[(i + 1) % corners.length];
    return [[x, y], [x + (nx - x) / 3, y + (ny - y) / 3], [x + (2 * (nx - x)) / 3, y + (2 * (ny - y)) / 3]];
  });
}

/** Four cubics around an ellipse; `turn` is 1 or −1. */
function ellipse(cx, cy, rx, ry, turn) {
  const at = (a, b) => [cx + turn * rx * a, cy + ry * b];
  const q = quarter;
  return [at(1, 0), at(1, q), at(q, 1), at(0, 1), at(-q, 1), at(-1, q), at(-1, 0), at(-1, -q), at(-q, -1),
    at(0, -1), at(q, -1), at(1, -q)];
}

const minus = (a, b) => a.map((p, i) => [p[0] - b[i][0], p[1] - b[i][1]]);

const ring = (cx, rx, thin, flat) => [...ellipse(cx, 350, rx, 360, 1), ...ellipse(cx, 350, rx - thin, 360 - flat, -1)];
const stem = (width) => polygon([[100, 0], [100 + width, 0], [100 + width, 700], [100, 700]]);

export function rawWord() {
  const o = ring(300, 250, 80, 60), i = stem(100);
  return {
    family: "Test Grotesk", string: "oil", units_per_em: 1000, ascender: 800, descender: -200,
    axes: [
      { tag: "wght", name: "Weight", minimum: 100, default: 400, maximum: 900, hidden: false, map: [[-1, -1], [0, 0], [1, 1]] },
      { tag: "wdth", name: "Width", minimum: 50, default: 100, maximum: 150, hidden: false, map: [[-1, -1], [0, 0], [1, 1]] },
    ],
    regions: { count: 2, data: floats([0, 1, 1, 0, 0, 0, /**/ 0, 0, 0, -1, -1, 0]) },
    glyphs: [
      {
        name: "o", contours: [4, 4], regions: [0, 1],
        points: floats([o, minus(ring(340, 290, 190, 110), o), minus(ring(200, 150, 80, 60), o)].flat(2)),
        advance: { default: 600, regions: [0, 1], deltas: [80, -200] },
      },
      {
        name: "il", contours: [4], regions: [0],
        points: floats([i, minus(stem(220), i)].flat(2)),
        advance: { default: 300, regions: [0], deltas: [40] },
      },
    ],
    ...oneRow([0, 1, 1]), tracking: 0, offsets: [[0, 0], [0, 0], [0, 7]],
  };
}

/** A word with one row of glyphs that only their advances set apart. @param {number[]} order the glyph of each letter */
export function oneRow(order) {
  const ends = [...order, null], nothing = { default: 0, regions: [], deltas: [] };
  const steps = ends.map(() => ({ x: nothing, y: nothing }));
  return {
    rows: [{
      order, clusters: order.map((_, i) => i), bases: order.map(() => 1),
      names: order.map((_, i) => "oil"[i] ?? "o"), lines: order.map(() => 0), anchors: ends.map((_, i) => i - 1),
      gaps: ends.map((_, i) => i), pushed: ends.map((_, i) => Array.from({ length: i }, (_, j) => [j, 1])), own: steps, anchored: steps,
    }],
    settings: { edges: [[], []], cells: [0] },
  };
}
