// @ts-check
/*
 * Builds DOM from data without ever parsing text as HTML. Knows nothing of the game.
 */

/**
 * One element. `props` are attributes (`class`, `for`, `aria-…`; true for an empty one, false/null/undefined to
 * leave it out) and handlers (`onclick`, …, as functions); children are nodes or text.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, unknown>} [props]
 * @param {...(Node | string | null | undefined)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(tag, props = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (value === false || value === null || value === undefined) continue;
    if (typeof value === "function")
      node.addEventListener(name.replace(/^on/, ""), /** @type {EventListener} */ (value));
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/**
 * The element with this id, which the page must have.
 * @template {HTMLElement} T
 * @param {string} id
 * @param {new () => T} kind
 * @returns {T}
 */
export function byId(id, kind) {
  const node = document.getElementById(id);
  if (!(node instanceof kind)) throw new Error(`the page has no <${kind.name} id="${id}">`);
  return node;
}

/**
 * The round mark of a seat: colour, letter and ring. Decorative: the name is beside it.
 * @param {number} seat 0 blue, 1 red
 */
export function badge(seat) {
  const colour = seat === 0 ? "blue" : "red";
  return el("span", { class: `badge badge-${colour}`, "aria-hidden": "true", translate: "no" }, seat === 0 ? "B" : "R");
}

/**
 * A message box; `kind` is "", "ok", "attention" or "bad".
 * @param {string} kind
 * @param {...(Node | string)} children
 */
export function notice(kind, ...children) {
  return el("div", { class: kind ? `notice notice-${kind}` : "notice" }, ...children);
}
