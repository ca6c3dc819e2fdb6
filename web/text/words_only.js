// @ts-check
/*
 * The only module of a page that has texts and does nothing: the page for unknown addresses.
 */

import { prepareTexts } from "./page.js";

await prepareTexts();
