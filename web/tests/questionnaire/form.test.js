// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { savingWords } from "../../questionnaire/form.js";
import { speak } from "../text/support.js";

test("a refused answer is explained in the reader's language, not in the server's words", () => {
  speak("de");
  const refused = new ApiError("wrong_token", "This needs the token of the seat.", 401);
  assert.match(savingWords({ waiting: 0, failure: null, refused }), /^Diese Seite hat keinen Zugriff mehr/);
  assert.match(savingWords({ waiting: 0, failure: null, refused: new TypeError("a bug") }), /schiefgegangen/);
});

test("answers that wait for a busy server are not said to have no connection", () => {
  speak("en");
  const busy = new ApiError("too_many_requests", "Too many requests.", 429);
  const gone = new ApiError("offline", "The server does not answer.", 0);
  assert.match(savingWords({ waiting: 1, failure: busy, refused: null }), /^The server cannot take your answers/);
  assert.match(savingWords({ waiting: 1, failure: gone, refused: null }), /^No connection/);
  assert.match(savingWords({ waiting: 0, failure: gone, refused: null }), /saved at once$/);
});
