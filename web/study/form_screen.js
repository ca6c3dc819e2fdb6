// @ts-check
/*
 * The screen of a form or questionnaire of a study: the shared form, whose answers go to the participant's place.
 */

import { QuestionForm } from "../questionnaire/form.js";
import { UnsentAnswers } from "../questionnaire/unsent_answers.js";
import { say } from "../text/catalogue.js";
import { unsentName } from "./kept_answers.js";

/** @param {import("./screen.js").Context} context @returns {import("./screen.js").Screen} */
export function formScreen({ step, kept, place, next }) {
  return new QuestionForm({
    title: step.title ?? "",
    about: step.partner_letter ? say("form.partner", { letter: step.partner_letter }) : "",
    items: step.items ?? [],
    answers: new Map(Object.entries(step.answers ?? {})),
    unsent: new UnsentAnswers(`${unsentName(place.token)} ${step.key}`),
    kept,
    send: (answer) => place.answer(step.key, answer),
    onDone: () => next(),
  });
}
