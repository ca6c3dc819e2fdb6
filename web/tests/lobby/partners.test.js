// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { partnerLine, partnerName, researchLine } from "../../lobby/partners.js";
import { speak } from "../text/support.js";

speak("en");

const BASS = {
  id: "bass@all",
  name: "DP/BASS",
  description: "Chooses. Well.",
  kind: "bass",
  policy: "dp",
  population: "scripted people of A and B; none of population C",
  tcr: { unseen: 0.7252, alone: 0.2676 },
};
const IDLE = {
  id: "idle",
  name: "Idle",
  description: "Stands still: the control condition.",
  kind: "idle",
  policy: "",
  population: "",
  tcr: { unseen: null, alone: null },
};

test("a partner has a name for people, never an id", () => {
  assert.equal(partnerName(BASS), "Trained partner (BASS)");
  assert.equal(partnerName(IDLE), "Partner who stands still");
  assert.equal(partnerName({ ...BASS, id: "my.module:Mine", name: "Mine" }), "Own agent (Mine)");
});

test("whoever plays reads what to expect of a trained partner, without abbreviations", () => {
  assert.equal(
    partnerLine(BASS),
    "Learned from recorded games. Gets 73 % of the work done with partners it never met.",
  );
  assert.equal(partnerLine({ ...BASS, tcr: { unseen: null, alone: null } }), "Learned from recorded games.");
});

test("researchers read what it is, whom it learned from and its score with people it never met", () => {
  assert.equal(
    researchLine(BASS),
    "Diffusion Policy with BASS, learned from scripted people of A and B. " +
      "TCR 0.73 with scripted people it never met (0.27 without help).",
  );
  assert.equal(
    researchLine({ ...BASS, kind: "gru", policy: "gru", tcr: { unseen: null, alone: null } }),
    "GRU, learned from scripted people of A and B.",
  );
});

test("a kind that the catalogue of texts does not know is called by its own word", () => {
  const mean = { ...BASS, kind: "mean", policy: "mean", tcr: { unseen: null, alone: null } };
  assert.equal(researchLine(mean), "mean, learned from scripted people of A and B.");
});

test("of an agent that was not trained nothing is invented", () => {
  assert.equal(partnerLine(IDLE), "Does nothing: you play alone.");
  assert.equal(researchLine(IDLE), "");
  assert.equal(
    partnerLine({ ...IDLE, id: "mine", description: "Waits, e.g.\u00a0here. Has options." }),
    "Waits, e.g.\u00a0here.",
  );
  assert.equal(partnerLine({ ...IDLE, id: "mine", description: "Waits for 1.5 s" }), "Waits for 1.5 s");
});
