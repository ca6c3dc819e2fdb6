// @ts-check
/*
 * Says in a browser that cannot show these pages that it is too old, in place of a page that does nothing. A classic
 * script in <head>, as theme.js, in words that browsers of 2015 understand: the modules of a page do not even load
 * there. It empties the page before they run, so that none of them starts.
 */

(function () {
  /** @type {Record<string, string>} by language, as those of language.js */
  const WORDS = {
    en:
      "This browser is too old for this page. " +
      "These can show it: Chrome and Edge from 108 on, Firefox from 121 on, Safari and iOS from 15.4 on.",
    de:
      "Dieser Browser ist zu alt für diese Seite. " +
      "Diese können sie zeigen: Chrome und Edge ab 108, Firefox ab 121, Safari und iOS ab 15.4.",
  };

  function isOld() {
    return !(
      typeof structuredClone === "function" && // Chrome 98, Firefox 94, Safari 15.4
      typeof HTMLDialogElement === "function" && // Firefox 98, Safari 15.4
      "findLast" in Array.prototype && // Chrome 97, Firefox 104, Safari 15.4
      CSS.supports("height", "1dvh") && // Chrome 108, Firefox 101, Safari 15.4
      CSS.supports("selector(:has(a))") // Chrome 105, Firefox 121, Safari 15.4: without it no chosen answer is marked
    );
  }

  function tell() {
    const main = document.createElement("main");
    main.className = "page page-narrow stack";
    main.setAttribute("role", "alert");
    for (const language of Object.keys(WORDS)) {
      const sentence = document.createElement("p");
      sentence.className = "notice notice-bad old-browser";
      sentence.lang = language;
      sentence.textContent = WORDS[language];
      main.appendChild(sentence);
    }
    document.body.textContent = "";
    document.body.appendChild(main);
  }

  if (!isOld()) return;
  document.addEventListener("readystatechange", function () {
    if (document.readyState === "interactive") tell(); // parsed, and before any module runs
  });
})();
