/** The status line: the most pressing of what there is to say, and a button for a better result. */
import { assign, attr, html } from "../view/dom.js";
import { BETTER } from "./messages.js";

/** @param {() => void} changed asks for a frame */
export function createStatus(changed) {
  let kind = "idle", text = "";
  const line = html("div", { class: "vfw-status", role: "status", "aria-live": "polite", tabindex: 0 });
  const better = html("button", { type: "button", class: "vfw-better", hidden: true }, BETTER);

  /** @param {string} newKind @param {string} newText */
  function say(newKind, newText) {
    assign(better, { hidden: true });
    if (kind === newKind && text === newText) return;
    [kind, text] = [newKind, newText];
    changed();
  }

  /** Offers a result far away that is better than that of a drag. @param {() => void} go */
  function offer(go) {
    better.hidden = false;
    better.onclick = go;
  }

  /** @param {import("./session.js").Session} session whose errors come first @param {string} hint said if there is nothing else */
  function show({ error, problems }, hint) {
    const wrong = error || [...problems.values()].join("\n"), words = wrong || text || hint;
    attr(line, "data-status", wrong ? "error" : kind);
    assign(line, { textContent: words, title: words });
  }

  return { line, better, say, offer, show, get kind() { return kind; } };
}
