// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { agentName, mapDescription, mapTitle, playerName, recordedPlayer, replayedPlayer } from "../../text/names.js";
import { speak } from "./support.js";

test("a map has the title of the catalogue, else its own, else its name in words", () => {
  speak("en");
  assert.equal(mapTitle({ name: "HandOff" }), "Hand Off");
  assert.equal(mapTitle({ name: "MyLab", title: "The lab" }), "The lab");
  assert.equal(mapTitle({ name: "TwoDoorsAhead" }), "Two Doors Ahead");
  assert.equal(mapTitle({ name: "Heder", title: "חדר!" }), "\u2068חדר!\u2069", "in its own direction");
});

test("a mirrored or turned map says so in its title", () => {
  speak("en");
  assert.equal(mapTitle({ name: "HandOff:mirror" }), "Hand Off, mirrored");
  assert.equal(mapTitle({ name: "HandOff:mirror:rot90", title: "HO" }), "Hand Off, mirrored, turned 90°");
  assert.equal(mapTitle({ name: "MyLab:rot270", title: "The lab" }), "The lab, turned 270°");
  assert.match(mapDescription({ name: "HandOff:rot180", description: "?" }), /narrow pathway/);
});

test("a generated map is called after its seed", () => {
  speak("en");
  assert.equal(mapTitle({ name: "generated:awareness:12", title: "?" }), "Surprise map 12");
  assert.equal(mapTitle({ name: "generated:consistency:7:mirror:rot90" }), "Surprise map 7, mirrored, turned 90°");
  assert.equal(mapTitle({ name: "generated:awareness:12:hard:mirror" }), "Surprise map 12, hard, mirrored");
  assert.match(mapDescription({ name: "generated:awareness:12", description: "?" }), /at random/);
  speak("de");
  assert.equal(mapTitle({ name: "generated:awareness:12" }), "Überraschungskarte 12");
});

test("an agent has a name that says what it is; any other name stays", () => {
  speak("en");
  const names = [
    "scripted:seed=3",
    "idle",
    "bass@all:execute=4",
    "bass-plain@a",
    "my-net@x",
    "lab.policy:Careful",
    "Partner A",
  ];
  assert.deepEqual(
    names.map((name) => agentName(name)),
    [
      "Computer partner",
      "Partner who stands still",
      "Trained partner (BASS)",
      "Trained partner (BASS, plain)",
      "Trained partner (my, net)",
      "Own agent (Careful)",
      "Partner A",
    ],
  );
  speak("de");
  assert.equal(agentName("dp@all"), "Trainierter Partner (DP)");
});

test("those who run a server see the id of an agent beside its name", () => {
  speak("en");
  assert.equal(playerName("agent", "bass@all"), "Trained partner (BASS) · bass@all");
  assert.equal(playerName("agent", "Partner A"), "Partner A");
  const tutor = "movingout.agents.scripted.patient_partner:PatientPartner";
  assert.equal(playerName("agent", tutor), `Partner in the tutorial · ${tutor}`, "nobody's own");
  assert.equal(playerName("human", "P7"), "P7");
  assert.equal(playerName("human", ""), "A person");
  assert.equal(playerName("idle", "idle"), "Partner who stands still");
  assert.equal(playerName("ghost", "ghost:E1#red"), "Recording · ghost:E1#red");
  assert.equal(playerName("", ""), "–");
});

test("the pseudonym of a room is no name on the pages that players see", () => {
  speak("en");
  assert.equal(recordedPlayer("person-k3x9ab"), "the other player");
  assert.equal(recordedPlayer("P7KXM2Q"), "the other player");
  assert.equal(recordedPlayer("scripted"), "Computer partner");
  assert.equal(replayedPlayer("human", "person-k3x9ab"), "A person");
  assert.equal(replayedPlayer("human", "P7KXM2Q"), "P7KXM2Q", "whoever may open a study knows its people by these");
  assert.equal(replayedPlayer("agent", "bass@all"), "Trained partner (BASS) · bass@all");
});
