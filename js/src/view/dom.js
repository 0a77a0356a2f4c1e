/** Elements without markup: text that comes from a font only ever becomes text nodes. */

const SVG = "http://www.w3.org/2000/svg";

/**
 * @template {Element} E
 * @param {E} element @param {Record<string, any>} attributes @param {(Node | string)[]} children
 * @returns {E}
 */
function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children);
  return element;
}

/** For elements whose keys JupyterLab must leave alone. */
export const KEEP_KEYS = "data-lm-suppress-shortcuts";

/** Sets an attribute, unless it has the value: browsers lay out again for equal ones. @param {Element} element @param {string} name @param {any} value */
export function attr(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

/** Sets properties that differ, for the same reason. @template {Element} E @param {E} element @param {Partial<E>} values */
export function assign(element, values) {
  for (const name in values) if (element[name] !== values[name]) element[name] = /** @type {any} */ (values[name]);
}

/**
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, any>} [attributes] @param {(Node | string)[]} children
 */
export function html(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/**
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag @param {Record<string, any>} [attributes] @param {(Node | string)[]} children
 */
export function svg(tag, attributes = {}, ...children) {
  return fill(/** @type {SVGElementTagNameMap[T]} */ (document.createElementNS(SVG, tag)), attributes, children);
}

/** A drawing of 16 × 16 in lines, which says nothing to a screen reader. @param {string} d */
export const icon = (d) => svg("svg", { class: "vfw-icon", viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d }));
