// @ts-check
/*
 * The language of the words that stand in a page until its texts have loaded, known before the first paint: a classic
 * script in <head>, as theme.js, whose `data-languages` are those of language.js. An element of class until-texts has a
 * child per language, of which the style sheet shows one.
 */

(() => {
  const offered = (document.currentScript?.dataset.languages ?? "en").split(" ");

  /** Of an address before in this tab, and chosen. */
  function kept() {
    try {
      return [sessionStorage.getItem("movingout.language"), localStorage.getItem("movingout.language")];
    } catch {
      return []; // storage is forbidden
    }
  }

  const wishes = [new URLSearchParams(location.search).get("lang"), ...kept(), ...navigator.languages];
  const known = wishes.map((wish) => wish?.split("-")[0] ?? "").find((wish) => offered.includes(wish));
  document.documentElement.dataset.firstLanguage = known ?? offered[0];
})();
