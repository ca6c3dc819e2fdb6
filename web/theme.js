// @ts-check
/*
 * The theme chosen by the reader, applied before the first paint. A classic script in <head> (a module would run
 * after it); knows nothing of the page. Kept as `movingout.theme` in localStorage; absent means the system's.
 */

(() => {
  const KEY = "movingout.theme";
  const NEXT = /** @type {Record<string, string>} */ ({ auto: "dark", dark: "light", light: "auto" });
  const LABEL = /** @type {Record<string, string>} */ ({ auto: "system", dark: "dark", light: "light" });

  /** @returns {string} auto, dark or light */
  function chosen() {
    try {
      const value = localStorage.getItem(KEY);
      return value === "dark" || value === "light" ? value : "auto";
    } catch {
      return "auto"; // storage is forbidden: the theme lasts for this page
    }
  }

  /** @param {string} theme */
  function apply(theme) {
    if (theme === "auto") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme;
    for (const button of document.querySelectorAll("[data-theme-button]")) {
      button.textContent = `Theme: ${LABEL[theme]}`; // until the texts of the page are there
      button.setAttribute("data-say", `theme.${theme}`);
    }
    window.dispatchEvent(new Event("movingout-theme")); // canvases read their colours again
  }

  /** @param {string} theme */
  function keep(theme) {
    try {
      if (theme === "auto") localStorage.removeItem(KEY);
      else localStorage.setItem(KEY, theme);
    } catch {
      // nothing to keep it in
    }
  }

  let theme = chosen();
  apply(theme);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => apply(theme));
  document.addEventListener("DOMContentLoaded", () => apply(theme));
  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element) || !event.target.closest("[data-theme-button]")) return;
    theme = NEXT[theme];
    keep(theme);
    apply(theme);
  });
})();
