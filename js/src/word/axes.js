/** User values of axes, and the normalized coordinates they stand for. No DOM. */

/** @typedef {import("./decode.js").Axis} Axis */

/**
 * A user value to a normalized coordinate: the default-relative scale, then the segment map.
 * @param {Pick<Axis, "minimum" | "default" | "maximum" | "map">} axis @param {number} user
 */
export function normalize(axis, user) {
  const { minimum, default: normal, maximum, map } = axis;
  const v = Math.min(Math.max(user, minimum), maximum);
  // A side of length zero is never divided by: no clamped value lies on it.
  const w = v < normal ? (v - normal) / (normal - minimum) : v > normal ? (v - normal) / (maximum - normal) : 0;
  const last = map.length - 1;
  if (last < 0) return w;
  if (w <= map[0][0]) return w - map[0][0] + map[0][1];
  for (let i = 1; i <= last; i++) {
    const [from, to] = map[i];
    if (w === from) return to;
    if (w < from) {
      const [from0, to0] = map[i - 1];
      return to0 + ((w - from0) / (from - from0)) * (to - to0);
    }
  }
  return w - map[last][0] + map[last][1];
}

/**
 * A normalized coordinate to a user value, the inverse of `normalize`. Where the segment map is flat, several
 * user values share one coordinate; the one nearest to the default is given.
 * @param {Pick<Axis, "minimum" | "default" | "maximum" | "map">} axis @param {number} w
 */
export function denormalize(axis, w) {
  const { minimum, default: normal, maximum } = axis;
  const home = normalize(axis, normal);
  if (w === home) return normal;
  const end = w > home ? maximum : minimum;
  const rises = Math.sign(w - home);
  // The corners of the map between the default and that end, from the default outwards.
  const corners = [normal, ...axis.map.map(([from]) => normal + Math.abs(from) * (end - normal))
    .filter((_, i) => Math.sign(axis.map[i][0]) === Math.sign(end - normal)), end]
    .sort((a, b) => Math.sign(end - normal) * (a - b));
  for (let i = 1; i < corners.length; i++) {
    const near = normalize(axis, corners[i - 1]), far = normalize(axis, corners[i]);
    if (rises * (far - w) >= 0 && far !== near) return corners[i - 1] + ((w - near) / (far - near)) * (corners[i] - corners[i - 1]);
  }
  return end;
}

/** A word's normalized coordinates. @param {Word} word @param {Record<string, number>} axes user values @param {Float64Array} w */
export function coordinates(word, axes, w) {
  for (let i = 0; i < w.length; i++) w[i] = normalize(word.axes[i], axes[word.axes[i].tag] ?? word.axes[i].default);
  return w;
}
