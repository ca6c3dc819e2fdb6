// @ts-check
/* What a participant's page takes from its link. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { recruitmentParameters } from "../../../study/arrivals/recruitment_link.js";

test("the server hears of an id that a platform left empty, which it refuses", () => {
  assert.deepEqual(recruitmentParameters("?PROLIFIC_PID=&STUDY_ID=s&other=1"), { PROLIFIC_PID: "", STUDY_ID: "s" });
  assert.deepEqual(recruitmentParameters("?workerId=%20&lang=de"), { workerId: " " });
});

test("an empty code is asked for, as none is", () => {
  assert.deepEqual(recruitmentParameters("?code="), {});
  assert.deepEqual(recruitmentParameters("?code=AB12"), { code: "AB12" });
});

test("of a link only what recruitment platforms put there is taken", () => {
  const query = "?PROLIFIC_PID=5f&STUDY_ID=s1&SESSION_ID=&workerId=W&code=AB-1&lang=de&utm=x";
  assert.deepEqual(recruitmentParameters(query), {
    PROLIFIC_PID: "5f",
    STUDY_ID: "s1",
    SESSION_ID: "",
    workerId: "W",
    code: "AB-1",
  });
  assert.deepEqual(recruitmentParameters(""), {});
});
